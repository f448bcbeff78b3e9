// SPDX-License-Identifier: GPL-2.0-or-later
// P M P^T = L S L^T
#include "host/inverse/factor.hpp"

#include <cblas.h>
#include <cholmod.h>
#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "host/base/error.hpp"
#include "host/inverse/numeric.hpp"

namespace haptable {

struct Factor::State {
    mutable cholmod_common common;
    cholmod_factor* factor = nullptr;
    // Workspace of the solves, kept from call to call.
    mutable cholmod_dense* x = nullptr;
    mutable cholmod_dense* y = nullptr;
    mutable cholmod_dense* e = nullptr;
    Pivot weakest;
    Eigen::Index size = 0;      // rows of K
    std::vector<int> positive;  // [supernodes] columns with S = 1, which stand first; empty: all

    State() {
        cholmod_start(&common);
        common.print = 0;
        common.supernodal = CHOLMOD_SUPERNODAL;
        common.final_ll = 1;
        common.nmethods = 1;
        common.method[0].ordering = CHOLMOD_GIVEN;
        common.postorder = 1;
        // Fewer zeros than by default are taken into supernodes: 3 % less memory at the same speed.
        common.nrelax[1] = 8;
        common.nrelax[2] = 24;
        common.zrelax[2] = 0.02;
    }
    ~State() {
        cholmod_free_dense(&x, &common);
        cholmod_free_dense(&y, &common);
        cholmod_free_dense(&e, &common);
        cholmod_free_factor(&factor, &common);
        cholmod_finish(&common);
    }
    State(const State&) = delete;
    State& operator=(const State&) = delete;

    void require(bool ok, const char* what) const {
        if (common.status == CHOLMOD_OUT_OF_MEMORY || common.status == CHOLMOD_TOO_LARGE)
            throw Error(fmt::format("{}: the factor is too large (about {:.1f} GB); use a coarser mesh", what,
                                    common.lnz * sizeof(double) / 1e9));
        if (!ok || common.status < CHOLMOD_OK)
            throw Error(fmt::format("{}: CHOLMOD failed with status {}; please report this mesh", what, common.status));
    }
};

namespace {

/// A view of k as CHOLMOD sees it; nothing is copied.
cholmod_sparse view(const Eigen::SparseMatrix<double>& k) {
    cholmod_sparse a{};
    a.nrow = static_cast<std::size_t>(k.rows());
    a.ncol = static_cast<std::size_t>(k.cols());
    a.nzmax = static_cast<std::size_t>(k.nonZeros());
    a.p = const_cast<int*>(k.outerIndexPtr());
    a.i = const_cast<int*>(k.innerIndexPtr());
    a.x = const_cast<double*>(k.valuePtr());
    a.stype = -1;  // symmetric: the upper triangle is not read
    a.itype = CHOLMOD_INT;
    a.xtype = CHOLMOD_REAL;
    a.dtype = CHOLMOD_DOUBLE;
    a.sorted = 1;
    a.packed = 1;
    return a;
}

/// The graph of the bundles, lower triangle: which have entries in common.
struct Graph {
    std::vector<int> begin{0}, neighbour;
};
Graph graph_of(const Eigen::SparseMatrix<double>& m, const Stiffness::Bundles& bundles) {
    const int count = static_cast<int>(bundles.begin.size()) - 1;
    std::vector<int> bundle_of(bundles.row.size()), seen(at(count), -1);
    const auto for_each_row = [&](int bundle, auto visit) {
        for (int r = bundles.begin[at(bundle)]; r < bundles.begin[at(bundle) + 1]; ++r) visit(bundles.row[at(r)]);
    };
    for (int b = 0; b < count; ++b) for_each_row(b, [&](int row) { bundle_of[at(row)] = b; });
    Graph graph;
    for (int b = 0; b < count; ++b) {
        for_each_row(b, [&](int row) {
            for (int e = m.outerIndexPtr()[row]; e < m.outerIndexPtr()[row + 1]; ++e) {
                const int a = bundle_of[at(m.innerIndexPtr()[e])];
                if (a > b && std::exchange(seen[at(a)], b) != b) graph.neighbour.push_back(a);
            }
        });
        std::sort(graph.neighbour.begin() + graph.begin.back(), graph.neighbour.end());
        graph.begin.push_back(static_cast<int>(graph.neighbour.size()));
    }
    return graph;
}

/// The rows of M, bundle by bundle, in METIS's order.
std::vector<int> order_rows(const Stiffness& k, cholmod_common& common) {
    const Stiffness::Bundles bundles = k.bundles();
    const std::size_t count = bundles.begin.size() - 1;
    Graph lower = graph_of(k.matrix(), bundles);
    cholmod_sparse graph{};
    graph.nrow = graph.ncol = count;
    graph.nzmax = lower.neighbour.size();
    graph.p = lower.begin.data();
    graph.i = lower.neighbour.data();
    graph.stype = -1;
    graph.itype = CHOLMOD_INT;
    graph.xtype = CHOLMOD_PATTERN;
    graph.dtype = CHOLMOD_DOUBLE;
    graph.sorted = graph.packed = 1;
    std::vector<int> order(count), rows;
    // Postordering is left to the analysis, which does it with all rows.
    if (!cholmod_metis(&graph, nullptr, 0, 0, order.data(), &common)) std::iota(order.begin(), order.end(), 0);
    for (int b : order)
        rows.insert(rows.end(), bundles.row.begin() + bundles.begin[at(b)],
                    bundles.row.begin() + bundles.begin[at(b) + 1]);
    return rows;
}

/// Puts a supernode's pressures behind its displacements, so that its signs change once at the most; within a
/// supernode any order has the same pattern. Returns how many of its columns are displacements.
///   size  rows of K: the rows of M from here on are pressures
std::vector<int> put_pressures_last(cholmod_factor& factor, Eigen::Index size) {
    auto* permutation = static_cast<int*>(factor.Perm);
    auto* row = static_cast<int*>(factor.s);
    const auto* super = static_cast<const int*>(factor.super);
    const auto* row_begin = static_cast<const int*>(factor.pi);
    const std::vector<int> before(permutation, permutation + factor.n);
    std::vector<int> place(factor.n), positive;
    for (std::size_t s = 0; s < factor.nsuper; ++s) {
        int next = super[s];
        for (const bool pressures : {false, true}) {
            for (int j = super[s]; j < super[s + 1]; ++j)
                if ((before[at(j)] >= size) == pressures) permutation[place[at(j)] = next++] = before[at(j)];
            if (!pressures) positive.push_back(next - super[s]);
        }
    }
    for (std::size_t s = 0; s < factor.nsuper; ++s) {
        std::transform(row + row_begin[s], row + row_begin[s + 1], row + row_begin[s],
                       [&](int r) { return place[at(r)]; });
        std::sort(row + row_begin[s], row + row_begin[s + 1]);
    }
    return positive;
}

cholmod_dense view(const Eigen::MatrixXd& b) {
    cholmod_dense d{};
    d.nrow = d.d = static_cast<std::size_t>(b.rows());
    d.ncol = static_cast<std::size_t>(b.cols());
    d.nzmax = static_cast<std::size_t>(b.size());
    d.x = const_cast<double*>(b.data());
    d.xtype = CHOLMOD_REAL;
    d.dtype = CHOLMOD_DOUBLE;
    return d;
}

/// Calls visit(column of L, l_jj) for every column of a supernodal factor.
template <typename Visit>
void for_each_pivot(const cholmod_factor& factor, Visit visit) {
    const auto* super = static_cast<const int*>(factor.super);
    const auto* rows = static_cast<const int*>(factor.pi);
    const auto* values = static_cast<const int*>(factor.px);
    const auto* x = static_cast<const double*>(factor.x);
    for (std::size_t s = 0; s < factor.nsuper; ++s) {
        const int height = rows[s + 1] - rows[s];
        for (int j = super[s]; j < super[s + 1]; ++j) {
            const std::ptrdiff_t c = j - super[s];
            visit(j, x[values[s] + c + c * height]);
        }
    }
}

/// The weakest pivot among the rows of K: no pivot of a pressure is nearer to 0 than its entry of M.
Pivot find_weakest(const cholmod_factor& factor, const Stiffness& k) {
    const auto* permutation = static_cast<const int*>(factor.Perm);
    if (factor.minor < factor.n) return {k.row_of_k(permutation[factor.minor]), 0.0};
    const Eigen::VectorXd diagonal = k.diagonal();
    Pivot weakest{0, 2.0};
    for_each_pivot(factor, [&](int j, double pivot) {
        const int row = permutation[j];
        if (row >= k.size()) return;
        const double ratio = pivot * pivot / diagonal[row];
        if (!(ratio >= weakest.ratio)) weakest = {row, ratio};
    });
    return weakest;
}

}  // namespace

Factor::Factor(const Stiffness& k, PatternOnly) : state_(std::make_unique<State>()) {
    if (k.size() % 3 != 0) throw Error(fmt::format("K has {} rows, and three a node are expected", k.size()));
    openblas_set_num_threads(1);
    cholmod_sparse m = view(k.matrix());
    std::vector<int> order = order_rows(k, state_->common);
    state_->require(state_->common.status == CHOLMOD_OK, "ordering of K");
    state_->factor = cholmod_analyze_p(&m, order.data(), nullptr, 0, &state_->common);
    state_->require(state_->factor != nullptr, "analysis of K");
    state_->size = k.size();
    if (k.pressures() > 0) state_->positive = put_pressures_last(*state_->factor, k.size());
}

Factor::Factor(const Stiffness& k) : Factor(k, kPattern) {
    Workers alone(1);
    Progress silent(true);
    factorize(k, alone, silent);
}

void Factor::factorize(const Stiffness& k, Workers& workers, Progress& progress) {
    // Takes the memory of a numeric factor and leaves its numbers open.
    const int ok = cholmod_change_factor(CHOLMOD_REAL, 1, 1, 1, 1, state_->factor, &state_->common);
    state_->require(ok != 0, "factorisation of K");
    const std::int32_t stopped =
        haptable::factorize(supernodes(), k.matrix(), static_cast<double*>(state_->factor->x), workers, progress);
    state_->factor->minor = stopped < 0 ? state_->factor->n : at(stopped);
    state_->weakest = find_weakest(*state_->factor, k);
}

Factor::~Factor() = default;

Eigen::Index Factor::size() const { return state_->size; }

void Factor::solve(const Eigen::MatrixXd& b, Eigen::MatrixXd& x) const {
    const State& state = *state_;
    const auto step = [&](int system, const cholmod_dense& given) {
        const int ok = cholmod_solve2(system, state.factor, const_cast<cholmod_dense*>(&given), nullptr, &state.x,
                                      nullptr, &state.y, &state.e, &state.common);
        state.require(ok != 0, "solve");
        const auto* values = static_cast<const double*>(state.x->x);
        x = Eigen::Map<const Eigen::MatrixXd>(values, static_cast<Eigen::Index>(state.factor->n), b.cols());
    };
    if (state.positive.empty()) return step(CHOLMOD_A, view(b));
    x = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(state.factor->n), b.cols());
    x.topRows(b.rows()) = b;
    step(CHOLMOD_P, view(x));
    step(CHOLMOD_L, view(x));
    const Supernodes s = supernodes();
    for (std::int32_t k = 0; k < s.count(); ++k)
        x.middleRows(s.first_column[at(k)] + s.positive_count(k), s.column_count(k) - s.positive_count(k)) *= -1.0;
    step(CHOLMOD_Lt, view(x));
    step(CHOLMOD_Pt, view(x));
    x = x.topRows(b.rows()).eval();
}

void Factor::release_workspace() const {
    cholmod_free_dense(&state_->x, &state_->common);
    cholmod_free_dense(&state_->y, &state_->common);
    cholmod_free_dense(&state_->e, &state_->common);
}

Pivot Factor::weakest_pivot() const { return state_->weakest; }

Supernodes Factor::supernodes() const {
    const cholmod_factor& factor = *state_->factor;
    const auto ints = [](const void* first, std::size_t count) {
        return std::span<const int>(static_cast<const int*>(first), count);
    };
    return {ints(factor.super, factor.nsuper + 1), ints(factor.pi, factor.nsuper + 1),
            ints(factor.px, factor.nsuper + 1),    ints(factor.s, factor.ssize),
            ints(factor.Perm, factor.n),           state_->positive,
            static_cast<const double*>(factor.x)};
}

double Factor::bytes() const {
    const cholmod_factor& factor = *state_->factor;
    const Supernodes s = supernodes();
    constexpr int kPage_entries = 512;
    double unused = 0.0;  // whole pages above the diagonal, which are never written
    for (std::int32_t k = 0; k < s.count(); ++k)
        for (int j = kPage_entries; j < s.column_count(k); ++j) unused += (j - kPage_entries) * sizeof(double);
    return static_cast<double>(factor.xsize) * sizeof(double) - unused +
           static_cast<double>(factor.ssize + 4 * factor.n) * sizeof(int);
}

double Factor::fill() const { return state_->common.lnz; }
double Factor::flops() const { return state_->common.fl; }

}  // namespace haptable
