// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/inverse/mpi/distributed_inverse.hpp"

#include <algorithm>
#include <chrono>
#include <numeric>
#include <thread>

#include "host/base/error.hpp"

namespace haptable {

namespace {

/// A list of rank 0's, on every rank.
void share(std::vector<std::int32_t>& list, MPI_Comm communicator) {
    auto count = static_cast<int>(list.size());
    MPI_Bcast(&count, 1, MPI_INT, 0, communicator);
    list.resize(at(count));
    MPI_Bcast(list.data(), count, MPI_INT32_T, 0, communicator);
}

/// Lists of all ranks, one after the other, on rank 0.
class ToLeader {
public:
    /// own: entries of this rank's lists.
    ToLeader(int own, int ranks, MPI_Comm communicator) : communicator_(communicator), own_(own), count_(at(ranks)) {
        MPI_Gather(&own, 1, MPI_INT, count_.data(), 1, MPI_INT, 0, communicator);
        begin_.resize(count_.size());
        std::exclusive_scan(count_.begin(), count_.end(), begin_.begin(), 0);
    }
    std::size_t total() const { return at(begin_.back() + count_.back()); }  ///< rank 0's
    void gather(const void* own, MPI_Datatype type, void* all) const {
        MPI_Gatherv(own, own_, type, all, count_.data(), begin_.data(), type, 0, communicator_);
    }

private:
    MPI_Comm communicator_;
    int own_;
    std::vector<int> count_, begin_;
};

/// One wanted entry: where it is in L, and which entry of which block it fills.
struct Want {
    std::int32_t column, row;
    std::size_t block;
    int r, c;

    auto place() const { return std::pair(column, row); }
};

/// Entries of the wanted blocks by column, then row. Of a block on the diagonal the lower triangle.
std::vector<Want> entries_of(std::span<const NodePair> wanted) {
    std::vector<Want> want;
    for (std::size_t b = 0; b < wanted.size(); ++b)
        for (int c = 0; c < 3; ++c)
            for (int r = wanted[b].row == wanted[b].column ? c : 0; r < 3; ++r)
                want.push_back({3 * wanted[b].column + c, 3 * wanted[b].row + r, b, r, c});
    std::sort(want.begin(), want.end(), [](const Want& a, const Want& b) { return a.place() < b.place(); });
    return want;
}

}  // namespace

DistributedInverse::DistributedInverse(MPI_Comm communicator) : communicator_(communicator), mumps_(communicator) {
    MPI_Comm_rank(communicator, &rank_);
    MPI_Comm_size(communicator, &ranks_);
}

DistributedInverse::~DistributedInverse() {
    if (leads()) begin(Task::kStop);
}

// ---- tasks ----------------------------------------------------------------------------------------------------------

void DistributedInverse::begin(Task task) const {
    int number = static_cast<int>(task);
    MPI_Request sent = MPI_REQUEST_NULL;
    MPI_Ibcast(&number, 1, MPI_INT, 0, communicator_, &sent);
    MPI_Wait(&sent, MPI_STATUS_IGNORE);
}

/// Sleeps while it waits: the leader's mesh and codegen take long, and MPI's own waiting keeps a processor busy.
DistributedInverse::Task DistributedInverse::wait() const {
    int number = 0, done = 0;
    MPI_Request request = MPI_REQUEST_NULL;
    MPI_Ibcast(&number, 1, MPI_INT, 0, communicator_, &request);
    for (MPI_Test(&request, &done, MPI_STATUS_IGNORE); !done; MPI_Test(&request, &done, MPI_STATUS_IGNORE))
        std::this_thread::sleep_for(std::chrono::microseconds(200));
    MPI_Wait(&request, MPI_STATUS_IGNORE);  // done: returns at once
    return static_cast<Task>(number);
}

void DistributedInverse::serve() {
    for (Task task = wait(); task != Task::kStop; task = wait()) try {
            take_part(task);
        } catch (const Error&) {  // all ranks throw it alike, and the leader says it
        }
}

void DistributedInverse::take_part(Task task) {
    Mumps::Entries none;
    Eigen::MatrixXd nothing;
    switch (task) {
        case Task::kAnalyse:
            mumps_.analyse({});
            need_of_fullest_machine();
            return;
        case Task::kFactorise:
            return mumps_.factorise();
        case Task::kSolve:
            return mumps_.solve(nothing);
        case Task::kInvert:
            return mumps_.invert(none);
        case Task::kRows:
            return share_rows({});
        case Task::kColumns:
            return solve_columns({}, {});
        case Task::kReport:
            processes();
            return;
        case Task::kStop:
            return;
    }
}

std::vector<double> DistributedInverse::gather(double own) const {
    std::vector<double> all(at(ranks_));
    MPI_Allgather(&own, 1, MPI_DOUBLE, all.data(), 1, MPI_DOUBLE, communicator_);
    return all;
}

// ---- factor ---------------------------------------------------------------------------------------------------------

MemoryNeed DistributedInverse::need_of_fullest_machine() const {
    MPI_Comm machine = MPI_COMM_NULL;
    MPI_Comm_split_type(communicator_, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
    double factor = mumps_.foreseen_bytes(), available = available_memory();
    MPI_Allreduce(MPI_IN_PLACE, &factor, 1, MPI_DOUBLE, MPI_SUM, machine);
    MPI_Allreduce(MPI_IN_PLACE, &available, 1, MPI_DOUBLE, MPI_MIN, machine);
    MPI_Comm_free(&machine);
    const std::vector<double> factors = gather(factor), availables = gather(available);
    MemoryNeed fullest;
    for (std::size_t r = 0; r < factors.size(); ++r)
        if (r == 0 || factors[r] - availables[r] > fullest.factor - fullest.available) {
            fullest.factor = factors[r];
            fullest.available = availables[r];
        }
    return fullest;
}

MemoryNeed DistributedInverse::analyse(const Stiffness& k, const InverseRequest& /*request*/) {
    begin(Task::kAnalyse);
    size_ = k.size();
    mumps_.analyse(k);
    MemoryNeed need = need_of_fullest_machine();
    need.stiffness = k.bytes();
    need.available += need.stiffness;  // K was there when the rest was measured
    return need;
}

FactorFacts DistributedInverse::factorize(const Stiffness& /*k*/, Progress& /*progress*/) {
    begin(Task::kFactorise);
    mumps_.factorise();
    return {"METIS", mumps_.fill(), mumps_.flops(), 1, {}};
}

void DistributedInverse::solve(const Eigen::MatrixXd& b, Eigen::MatrixXd& x) const {
    x = Eigen::MatrixXd::Zero(mumps_.size(), b.cols());
    x.topRows(size()) = b;
    begin(Task::kSolve);
    mumps_.solve(x);
    x.conservativeResize(size(), Eigen::NoChange);
}

Blocks DistributedInverse::blocks(std::span<const NodePair> wanted, Precision /*precision*/, Progress& /*progress*/) {
    const std::vector<Want> want = entries_of(wanted);
    Mumps::Entries entries;
    for (std::size_t e = 0; e < want.size(); ++e) {
        if (e > 0 && want[e].place() == want[e - 1].place()) continue;
        entries.column.push_back(want[e].column);
        entries.row.push_back(want[e].row);
    }
    begin(Task::kInvert);
    mumps_.invert(entries);
    Blocks blocks{std::vector<Eigen::Matrix3d>(wanted.size()),
                  {"MUMPS, entries of the inverse", Precision::kDouble, 0.0}};
    for (std::size_t e = 0, next = 0; e < want.size(); ++e) {
        const Want& w = want[e];
        if (e > 0 && w.place() != want[e - 1].place()) ++next;
        blocks.l_ij[w.block](w.r, w.c) = entries.value[next];
        if (wanted[w.block].row == wanted[w.block].column) blocks.l_ij[w.block](w.c, w.r) = entries.value[next];
    }
    return blocks;
}

// ---- columns --------------------------------------------------------------------------------------------------------

/// Columns in groups of neighbours in the elimination tree, which share their way to its root.
class DistributedInverse::RankColumns : public Columns {
public:
    RankColumns(DistributedInverse& inverse, std::span<const std::int32_t> node, std::span<const std::int32_t> row)
        : inverse_(inverse), node_(node.begin(), node.end()), row_(row.begin(), row.end()), order_(node.size()) {
        std::iota(order_.begin(), order_.end(), 0);
        const auto place = [&](std::size_t c) { return inverse.mumps_.order()[3 * at(node_[c])]; };
        std::sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) { return place(a) < place(b); });
    }
    std::size_t group_count() const override { return (order_.size() + kGroup - 1) / kGroup; }
    void for_each_block(std::size_t group, const Visit& visit) const override {
        for (std::size_t c : columns_of(group))
            for (std::size_t k = 0; k < row_.size(); ++k) visit(c, k);
    }
    ColumnFacts compute(Progress& progress, const Sink& sink) const override {
        ColumnFacts facts;
        inverse_.begin(Task::kRows);
        inverse_.share_rows(row_);
        for (std::size_t g = 0; g < group_count(); ++g) {
            progress.done(static_cast<double>(g) / static_cast<double>(group_count()));
            if (sink.have && sink.have(g))
                facts.resumed += columns_of(g).size();
            else
                solve(g, sink);
        }
        return facts;
    }

private:
    static constexpr std::size_t kGroup = 64;

    std::span<const std::size_t> columns_of(std::size_t group) const {
        return std::span(order_).subspan(kGroup * group, std::min(kGroup, order_.size() - kGroup * group));
    }
    void solve(std::size_t group, const Sink& sink) const {
        const std::span<const std::size_t> columns = columns_of(group);
        std::vector<std::int32_t> nodes;
        for (std::size_t c : columns) nodes.push_back(node_[c]);
        inverse_.begin(Task::kColumns);
        inverse_.solve_columns(nodes, [&](std::size_t i, const Eigen::MatrixX3f& column) {
            for (std::size_t k = 0; k < row_.size(); ++k)
                sink.take(columns[i], k, column.middleRows<3>(3 * static_cast<Eigen::Index>(k)));
        });
        if (sink.done) sink.done(group);
    }

    DistributedInverse& inverse_;
    std::vector<std::int32_t> node_, row_;
    std::vector<std::size_t> order_;  // of the columns, along the elimination tree
};

std::unique_ptr<Columns> DistributedInverse::columns(std::span<const std::int32_t> node,
                                                     std::span<const std::int32_t> row, Precision /*precision*/) {
    return std::make_unique<RankColumns>(*this, node, row);
}

void DistributedInverse::share_rows(std::vector<std::int32_t> row) {
    share(row, communicator_);
    wanted_rows_ = 3 * static_cast<Eigen::Index>(row.size());
    place_of_row_.assign(at(mumps_.size()), -1);
    for (std::size_t k = 0; k < row.size(); ++k)
        for (std::size_t c = 0; c < 3; ++c) place_of_row_[3 * at(row[k]) + c] = static_cast<std::int32_t>(3 * k + c);
}

/// One group: solved by all ranks; each then sends the wanted rows that it holds, one node's columns at a time, so that
/// no rank ever holds a group.
void DistributedInverse::solve_columns(std::vector<std::int32_t> node, const TakeColumn& take) {
    share(node, communicator_);
    std::vector<std::int32_t> unit;
    for (std::int32_t i : node)
        for (std::int32_t c = 0; c < 3; ++c) unit.push_back(3 * i + c);
    mumps_.solve_units(leads() ? unit : std::vector<std::int32_t>(), static_cast<int>(unit.size()));
    std::vector<std::int32_t> local, place;  // of wanted rows: in the local solution, and 3 k + component
    for (std::size_t e = 0; e < mumps_.local_row().size(); ++e)
        if (const std::int32_t row = place_of_row_[at(mumps_.local_row()[e] - 1)]; row >= 0) {
            local.push_back(static_cast<std::int32_t>(e));
            place.push_back(row);
        }
    const ToLeader rows(static_cast<int>(local.size()), ranks_, communicator_);
    std::vector<std::int32_t> all_places(leads() ? rows.total() : 0);
    rows.gather(place.data(), MPI_INT32_T, all_places.data());
    std::vector<float> own(local.size()), all(all_places.size());
    Eigen::MatrixX3f column(wanted_rows_, 3);
    for (std::size_t c = 0; c < unit.size(); ++c) {
        for (std::size_t e = 0; e < local.size(); ++e)
            own[e] = static_cast<float>(mumps_.local_solution()(local[e], static_cast<Eigen::Index>(c)));
        rows.gather(own.data(), MPI_FLOAT, all.data());
        for (std::size_t e = 0; e < all.size(); ++e) column(all_places[e], static_cast<Eigen::Index>(c % 3)) = all[e];
        if (leads() && c % 3 == 2) take(c / 3, column);
    }
}

std::vector<ProcessCost> DistributedInverse::processes() const {
    if (leads()) begin(Task::kReport);
    const ProcessCost own = process_cost();
    const std::vector<double> seconds = gather(own.cpu_s), peaks = gather(own.peak_bytes);
    std::vector<ProcessCost> costs;
    for (std::size_t r = 0; r < seconds.size(); ++r) costs.push_back({seconds[r], peaks[r]});
    return costs;
}

}  // namespace haptable
