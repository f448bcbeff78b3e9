// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/mpi/cluster.hpp"

#include <fmt/format.h>
#include <sys/resource.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>
#include <numeric>
#include <optional>
#include <thread>

#include "host/base/error.hpp"
#include "host/inverse/memory.hpp"
#include "host/inverse/selected_inversion.hpp"
#include "host/precompute/summary.hpp"
#include "host/tables/npy.hpp"

namespace haptable {

namespace {

/// A list of rank 0's, on every rank.
template <typename List>
void share(List& list, MPI_Comm communicator) {
    auto count = static_cast<std::int64_t>(list.size());
    MPI_Bcast(&count, 1, MPI_INT64_T, 0, communicator);
    list.resize(static_cast<std::size_t>(count));
    MPI_Bcast(list.data(), static_cast<int>(list.size() * sizeof(list[0])), MPI_BYTE, 0, communicator);
}

/// Where each rank's part begins.
std::vector<int> begins_of(const std::vector<int>& count) {
    std::vector<int> begin(count.size(), 0);
    std::exclusive_scan(count.begin(), count.end(), begin.begin(), 0);
    return begin;
}

/// One wanted entry: where it is in L, and which entry of which block it fills.
struct Want {
    std::int32_t column, row;
    std::size_t block;
    int r, c;
};

/// Entries of the wanted blocks by column, then row. Of a block on the diagonal the lower triangle.
std::vector<Want> entries_of(std::span<const NodePair> wanted) {
    std::vector<Want> want;
    for (std::size_t b = 0; b < wanted.size(); ++b)
        for (int c = 0; c < 3; ++c)
            for (int r = wanted[b].row == wanted[b].column ? c : 0; r < 3; ++r)
                want.push_back({3 * wanted[b].column + c, 3 * wanted[b].row + r, b, r, c});
    std::sort(want.begin(), want.end(),
              [](const Want& a, const Want& b) { return std::pair(a.column, a.row) < std::pair(b.column, b.row); });
    return want;
}

/// A file at its full size; one of this shape keeps its values.
template <typename T>
void make_file(const std::filesystem::path& path, std::size_t nodes, std::size_t rows) {
    const WritableNpy<T> file(path, {nodes, rows, 3, 3}, true);
}

/// Of one column as it is in the file. A group's is the exclusive or of its columns', whoever wrote which.
std::uint64_t hash_column(const void* bytes, std::size_t size, std::int32_t place) {
    return XXH3_64bits_withSeed(bytes, size, static_cast<XXH64_hash_t>(place));
}

/// The same from the file.
template <typename T>
std::uint64_t hash_columns(const std::filesystem::path& path, std::span<const std::int32_t> place, std::size_t rows) {
    const MappedNpy<T> file(path);
    std::uint64_t hash = 0;
    for (std::int32_t i : place)
        hash ^= hash_column(&file.values()[9 * rows * static_cast<std::size_t>(i)], 9 * rows * sizeof(T), i);
    return hash;
}

}  // namespace

Cluster::Cluster(MPI_Comm communicator) : communicator_(communicator), mumps_(communicator) {
    MPI_Comm_rank(communicator, &rank_);
    MPI_Comm_size(communicator, &ranks_);
}

Cluster::~Cluster() {
    if (leads()) begin(Task::kStop);
    close_columns();
}

// ---- tasks ----------------------------------------------------------------------------------------------------------

void Cluster::begin(Task task) const {
    int number = static_cast<int>(task);
    MPI_Request sent = MPI_REQUEST_NULL;
    MPI_Ibcast(&number, 1, MPI_INT, 0, communicator_, &sent);
    MPI_Wait(&sent, MPI_STATUS_IGNORE);
}

/// Sleeps while it waits: the leader's mesh and codegen take long, and MPI's own waiting keeps a processor busy.
Cluster::Task Cluster::wait() const {
    int number = 0, done = 0;
    MPI_Request request = MPI_REQUEST_NULL;
    MPI_Ibcast(&number, 1, MPI_INT, 0, communicator_, &request);
    for (MPI_Test(&request, &done, MPI_STATUS_IGNORE); !done; MPI_Test(&request, &done, MPI_STATUS_IGNORE))
        std::this_thread::sleep_for(std::chrono::microseconds(200));
    MPI_Wait(&request, MPI_STATUS_IGNORE);  // done: returns at once
    return static_cast<Task>(number);
}

void Cluster::serve() {
    for (Task task = wait(); task != Task::kStop; task = wait()) try {
            take_part(task);
        } catch (const Error&) {  // all ranks throw it alike, and the leader says it
        }
}

void Cluster::take_part(Task task) {
    Mumps::Entries none;
    Eigen::MatrixXd nothing;
    switch (task) {
        case Task::kAnalyse:
            mumps_.analyse({});
            missing_bytes();
            break;
        case Task::kFactorise:
            mumps_.factorise();
            break;
        case Task::kSolve:
            mumps_.solve(nothing);
            break;
        case Task::kInvert:
            mumps_.invert(none);
            break;
        case Task::kBlocks:
            write_slice({}, 0, {});
            break;
        case Task::kOpen:
            open_columns({}, {}, {});
            break;
        case Task::kColumns:
            solve_columns({}, {});
            break;
        case Task::kClose:
            close_columns();
            break;
        case Task::kReport:
            report(*std::make_unique<Summary>());
            break;
        case Task::kStop:
            break;
    }
}

/// Throws on every rank the first rank's failure, where any has one.
void Cluster::agree(const std::string& failed) const {
    int first = failed.empty() ? ranks_ : rank_;
    MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, communicator_);
    if (first == ranks_) return;
    std::array<char, 1000> text{};
    std::copy_n(failed.begin(), std::min(failed.size(), text.size() - 1), text.begin());
    MPI_Bcast(text.data(), static_cast<int>(text.size()), MPI_CHAR, first, communicator_);
    throw Error(fmt::format("rank {}: {}", first, text.data()));
}

std::vector<double> Cluster::gather(double own) const {
    std::vector<double> all(static_cast<std::size_t>(ranks_));
    MPI_Allgather(&own, 1, MPI_DOUBLE, all.data(), 1, MPI_DOUBLE, communicator_);
    return all;
}

// ---- factor ---------------------------------------------------------------------------------------------------------

/// Bytes that the ranks of the fullest machine need together beyond what it has; negative where all fits.
double Cluster::missing_bytes() const {
    MPI_Comm machine = MPI_COMM_NULL;
    MPI_Comm_split_type(communicator_, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
    double missing = mumps_.foreseen_bytes(), available = available_memory();
    MPI_Allreduce(MPI_IN_PLACE, &missing, 1, MPI_DOUBLE, MPI_SUM, machine);
    MPI_Allreduce(MPI_IN_PLACE, &available, 1, MPI_DOUBLE, MPI_MIN, machine);
    MPI_Comm_free(&machine);
    missing -= available;
    MPI_Allreduce(MPI_IN_PLACE, &missing, 1, MPI_DOUBLE, MPI_MAX, communicator_);
    return missing;
}

void Cluster::factorize(const Eigen::SparseMatrix<double>& k, Summary& summary) {
    begin(Task::kAnalyse);
    mumps_.analyse(k);
    const double missing = missing_bytes();
    if (missing > 0.0)
        throw Error(
            fmt::format("the factor does not fit: a machine would need {:.3g} GB more; use more machines, a "
                        "coarser mesh, or fewer ranks on each",
                        missing / 1e9));
    begin(Task::kFactorise);
    mumps_.factorise();
    summary.ordering = "METIS";
    summary.fill = mumps_.fill();
    summary.flops = mumps_.flops();
    summary.memory.stiffness = static_cast<double>(k.nonZeros()) * (sizeof(double) + sizeof(int));
    summary.memory.factor = mumps_.foreseen_bytes();  // of rank 0
    summary.threads = 1;
}

void Cluster::solve(const Eigen::MatrixXd& b, Eigen::MatrixXd& x) const {
    x = b;
    begin(Task::kSolve);
    mumps_.solve(x);
}

std::vector<Eigen::Matrix3d> Cluster::blocks(std::span<const NodePair> wanted) {
    const std::vector<Want> want = entries_of(wanted);
    Mumps::Entries entries;
    for (const Want& w : want) {
        entries.column.push_back(w.column);
        entries.row.push_back(w.row);
    }
    begin(Task::kInvert);
    mumps_.invert(entries);
    std::vector<Eigen::Matrix3d> block(wanted.size());
    for (std::size_t e = 0; e < want.size(); ++e) {
        const Want& w = want[e];
        block[w.block](w.r, w.c) = entries.value[e];
        if (wanted[w.block].row == wanted[w.block].column) block[w.block](w.c, w.r) = entries.value[e];
    }
    return block;
}

// ---- columns --------------------------------------------------------------------------------------------------------

void Cluster::open_columns(std::string path, std::vector<std::int32_t> place_of_row, const ColumnFormat& format) {
    share(path, communicator_);
    share(place_of_row, communicator_);
    place_of_row_ = std::move(place_of_row);
    format_ = format;
    MPI_Bcast(&format_, sizeof format_, MPI_BYTE, 0, communicator_);
    std::array<std::int64_t, 2> sizes{header_bytes_, static_cast<std::int64_t>(row_count_)};
    MPI_Bcast(sizes.data(), 2, MPI_INT64_T, 0, communicator_);
    header_bytes_ = sizes[0];
    row_count_ = static_cast<std::size_t>(sizes[1]);
    sent_count_.clear();
    const int failed = MPI_File_open(communicator_, path.c_str(), MPI_MODE_WRONLY, MPI_INFO_NULL, &file_);
    agree(failed == MPI_SUCCESS ? "" : path + ": cannot be written: do all machines see this folder?");
}

/// Neighbours in the elimination tree share their way to its root.
std::vector<std::int32_t> Cluster::order_along_tree(std::span<const std::int32_t> node) const {
    std::vector<std::int32_t> order(node.size());
    std::iota(order.begin(), order.end(), 0);
    const auto place = [&](std::int32_t i) {
        return mumps_.order()[3 * static_cast<std::size_t>(node[static_cast<std::size_t>(i)])];
    };
    std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) { return place(a) < place(b); });
    return order;
}

/// The file, and all that ranks must know to fill it.
void Cluster::make_columns(const ColumnTask& task) {
    std::error_code failed;
    std::filesystem::create_directories(task.folder, failed);
    if (failed) throw Error(fmt::format("{}: cannot be written: {}", task.folder.string(), failed.message()));
    const std::filesystem::path file = task.folder / "columns.npy";
    if (task.format.half)
        make_file<Half>(file, task.node_count, task.row.size());
    else
        make_file<float>(file, task.node_count, task.row.size());
    const std::size_t value_bytes = task.format.half ? sizeof(Half) : sizeof(float);
    row_count_ = task.row.size();
    header_bytes_ =
        static_cast<MPI_Offset>(std::filesystem::file_size(file) - 9 * value_bytes * task.node_count * row_count_);
    std::vector<std::int32_t> place_of_row(static_cast<std::size_t>(size()), -1);
    for (std::size_t k = 0; k < task.row.size(); ++k)
        for (std::size_t c = 0; c < 3; ++c)
            place_of_row[3 * static_cast<std::size_t>(task.row[k]) + c] = static_cast<std::int32_t>(3 * k + c);
    begin(Task::kOpen);
    open_columns(file.string(), std::move(place_of_row), task.format);
}

std::size_t Cluster::write_columns(const ColumnTask& task, Progress& progress) {
    const std::vector<std::int32_t> order = order_along_tree(task.node);
    // Another number of ranks may order otherwise, and its groups are others.
    ColumnJournal journal(task.folder / "journal",
                          XXH3_64bits_withSeed(order.data(), order.size() * sizeof order[0], task.key));
    make_columns(task);
    journal.begin();
    std::size_t kept = 0, group = 0;
    for (std::size_t first = 0; first < order.size(); first += kNodesAtOnce, ++group) {
        progress.done(static_cast<double>(first) / static_cast<double>(order.size()));
        std::vector<std::int32_t> unknown, place;
        for (std::size_t i = first; i < std::min(order.size(), first + kNodesAtOnce); ++i) {
            unknown.push_back(task.node[static_cast<std::size_t>(order[i])]);
            place.push_back(static_cast<std::int32_t>(task.place[static_cast<std::size_t>(order[i])]));
        }
        const auto found = journal.found().find(group);
        const std::filesystem::path file = task.folder / "columns.npy";
        if (found != journal.found().end() &&
            found->second == (task.format.half ? hash_columns<Half>(file, place, row_count_)
                                               : hash_columns<float>(file, place, row_count_))) {
            journal.add(group, found->second);
            kept += place.size();
            continue;
        }
        begin(Task::kColumns);
        journal.add(group, solve_columns(place, unknown));
    }
    begin(Task::kClose);
    close_columns();
    return kept;
}

// ---- blocks in slices -----------------------------------------------------------------------------------------------

void Cluster::write_blocks(const std::filesystem::path& file, const std::vector<std::size_t>& shape,
                           std::span<const double> values) {
    { const WritableNpy<double> made(file, shape); }
    const auto header = static_cast<std::int64_t>(std::filesystem::file_size(file) - values.size_bytes());
    begin(Task::kBlocks);
    write_slice(file.string(), header, values);
}

/// Rank 0's: the file and its values. Whole blocks of nine go to the ranks, as many to each as to the next, or one
/// more.
void Cluster::write_slice(std::string path, std::int64_t header_bytes, std::span<const double> values) {
    share(path, communicator_);
    std::array<std::int64_t, 2> sizes{header_bytes, static_cast<std::int64_t>(values.size() / 9)};
    MPI_Bcast(sizes.data(), 2, MPI_INT64_T, 0, communicator_);
    std::vector<int> count(static_cast<std::size_t>(ranks_));
    for (int r = 0; r < ranks_; ++r) count[static_cast<std::size_t>(r)] = 9 * nodes_of(r, static_cast<int>(sizes[1]));
    const std::vector<int> first = begins_of(count);
    const auto self = static_cast<std::size_t>(rank_);
    std::vector<double> own(static_cast<std::size_t>(count[self]));
    MPI_Scatterv(values.data(), count.data(), first.data(), MPI_DOUBLE, own.data(), count[self], MPI_DOUBLE, 0,
                 communicator_);
    MPI_File file = MPI_FILE_NULL;
    const int opened = MPI_File_open(communicator_, path.c_str(), MPI_MODE_WRONLY, MPI_INFO_NULL, &file);
    agree(opened == MPI_SUCCESS ? "" : path + ": cannot be written: do all machines see this folder?");
    const MPI_Offset at = sizes[0] + static_cast<MPI_Offset>(sizeof(double)) * first[self];
    const int written = MPI_File_write_at_all(file, at, own.data(), count[self], MPI_DOUBLE, MPI_STATUS_IGNORE);
    MPI_File_close(&file);
    agree(written == MPI_SUCCESS ? "" : path + ": cannot be written: is the disk full?");
}

// ---- one group of columns -------------------------------------------------------------------------------------------

/// One group of columns: solved by all ranks, then each rank gathers and writes the columns of its nodes: every
/// ranks_-th. Rank 0's: the nodes' places in the table and among the unknowns.
/// Returns the hash of what was written.
std::uint64_t Cluster::solve_columns(std::vector<std::int32_t> place, std::span<const std::int32_t> unknown_node) {
    share(place, communicator_);
    const auto count = static_cast<int>(place.size());
    std::vector<std::int32_t> column;
    if (leads())
        for (std::int32_t node : unknown_node)
            for (std::int32_t c = 0; c < 3; ++c) column.push_back(3 * node + c);
    mumps_.solve_units(column, 3 * count);
    if (sent_count_.empty()) find_senders();
    std::vector<std::int32_t> own;
    for (auto i = static_cast<std::size_t>(rank_); i < place.size(); i += static_cast<std::size_t>(ranks_))
        own.push_back(place[i]);
    written_hash_ = 0;
    agree(write(exchange(static_cast<int>(own.size()), count), own));
    MPI_Allreduce(MPI_IN_PLACE, &written_hash_, 1, MPI_UINT64_T, MPI_BXOR, communicator_);
    return written_hash_;
}

/// Which wanted rows each rank holds: the same for every group.
void Cluster::find_senders() {
    std::vector<std::int32_t> mine;
    own_row_.clear();
    for (std::size_t e = 0; e < mumps_.local_row().size(); ++e) {
        const std::int32_t row = place_of_row_[static_cast<std::size_t>(mumps_.local_row()[e] - 1)];
        if (row < 0) continue;
        mine.push_back(row);
        own_row_.push_back(static_cast<std::int32_t>(e));
    }
    sent_count_.resize(static_cast<std::size_t>(ranks_));
    const auto count = static_cast<int>(mine.size());
    MPI_Allgather(&count, 1, MPI_INT, sent_count_.data(), 1, MPI_INT, communicator_);
    sent_row_.resize(3 * row_count_);
    MPI_Allgatherv(mine.data(), count, MPI_INT32_T, sent_row_.data(), sent_count_.data(), begins_of(sent_count_).data(),
                   MPI_INT32_T, communicator_);
}

/// From every rank its wanted rows of this rank's nodes: sender by sender, node by node, row by row, 3 numbers each.
std::vector<float> Cluster::exchange(int own_nodes, int count) const {
    std::vector<float> sent;
    std::vector<int> sent_to, received_from;
    for (int to = 0; to < ranks_; ++to) {
        for (int i = to; i < count; i += ranks_)
            for (std::int32_t row : own_row_)
                for (int c = 0; c < 3; ++c) sent.push_back(static_cast<float>(mumps_.local_solution()(row, 3 * i + c)));
        sent_to.push_back(3 * static_cast<int>(own_row_.size()) * nodes_of(to, count));
        received_from.push_back(3 * sent_count_[static_cast<std::size_t>(to)] * own_nodes);
    }
    std::vector<float> received(9 * row_count_ * static_cast<std::size_t>(own_nodes));
    MPI_Alltoallv(sent.data(), sent_to.data(), begins_of(sent_to).data(), MPI_FLOAT, received.data(),
                  received_from.data(), begins_of(received_from).data(), MPI_FLOAT, communicator_);
    return received;
}

/// Returns what failed, or nothing.
std::string Cluster::write(std::span<const float> received, std::span<const std::int32_t> own_place) {
    std::vector<float> column(9 * row_count_);
    std::vector<Half> half(format_.half ? column.size() : 0);
    const auto per_unit = static_cast<float>(1.0 / format_.unit_m_per_n);
    bool well = true;
    for (std::size_t i = 0; i < own_place.size(); ++i) {
        std::size_t row = 0, from = 0;
        for (int count : sent_count_) {
            const auto rows = static_cast<std::size_t>(count);
            for (std::size_t r = 0; r < rows; ++r)
                std::copy_n(&received[from + 3 * (rows * i + r)], 3,
                            &column[3 * static_cast<std::size_t>(sent_row_[row + r])]);
            row += rows;
            from += 3 * rows * own_place.size();
        }
        for (std::size_t e = 0; e < half.size(); ++e) half[e] = to_half(column[e] * per_unit);
        const void* bytes = format_.half ? static_cast<const void*>(half.data()) : column.data();
        const std::size_t size = column.size() * (format_.half ? sizeof(Half) : sizeof(float));
        const MPI_Offset at = header_bytes_ + static_cast<MPI_Offset>(size) * own_place[i];
        written_hash_ ^= hash_column(bytes, size, own_place[i]);
        well &= MPI_File_write_at(file_, at, bytes, static_cast<int>(size), MPI_BYTE, MPI_STATUS_IGNORE) == MPI_SUCCESS;
    }
    return well ? "" : "columns.npy: cannot be written: is the disk full?";
}

void Cluster::close_columns() {
    if (file_ != MPI_FILE_NULL) MPI_File_close(&file_);
}

void Cluster::report(Summary& summary) {
    if (leads()) begin(Task::kReport);
    timespec cpu{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &cpu);
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    summary.rank_cpu_s = gather(static_cast<double>(cpu.tv_sec) + 1e-9 * static_cast<double>(cpu.tv_nsec));
    summary.rank_peak_bytes = gather(1024.0 * static_cast<double>(usage.ru_maxrss));
    summary.block_method = "MUMPS, entries of the inverse";
    summary.block_precision = "double";
}

}  // namespace haptable
