// SPDX-License-Identifier: GPL-2.0-or-later
// P K P^T = L L^T
#include "host/inverse/factor.hpp"

#include <cholmod.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <utility>

#include "host/base/error.hpp"
#include "host/inverse/numeric.hpp"

extern "C" void openblas_set_num_threads(int threads);  // declared in OpenBLAS's own cblas.h only

namespace haptable {

struct Factor::State {
    mutable cholmod_common common;
    cholmod_factor* factor = nullptr;
    // Workspace of the solves, kept from call to call.
    mutable cholmod_dense* x = nullptr;
    mutable cholmod_dense* y = nullptr;
    mutable cholmod_dense* e = nullptr;
    Pivot weakest;

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

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

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

/// The graph of the nodes: one row for every three of K, where any entry of their 3x3 block is stored.
std::vector<int> order_nodes(const Eigen::SparseMatrix<double>& k, cholmod_common& common) {
    const int nodes = static_cast<int>(k.rows()) / 3;
    std::vector<int> begin{0}, neighbour, seen(static_cast<std::size_t>(nodes), -1);
    for (int b = 0; b < nodes; ++b) {
        for (int e = k.outerIndexPtr()[Eigen::Index{3} * b]; e < k.outerIndexPtr()[Eigen::Index{3} * b + 3]; ++e) {
            const int a = k.innerIndexPtr()[e] / 3;
            if (a > b && std::exchange(seen[static_cast<std::size_t>(a)], b) != b) neighbour.push_back(a);
        }
        std::sort(neighbour.begin() + begin.back(), neighbour.end());
        begin.push_back(static_cast<int>(neighbour.size()));
    }
    cholmod_sparse graph{};
    graph.nrow = graph.ncol = static_cast<std::size_t>(nodes);
    graph.nzmax = neighbour.size();
    graph.p = begin.data();
    graph.i = neighbour.data();
    graph.stype = -1;
    graph.itype = CHOLMOD_INT;
    graph.xtype = CHOLMOD_PATTERN;
    graph.dtype = CHOLMOD_DOUBLE;
    graph.sorted = graph.packed = 1;
    std::vector<int> order(static_cast<std::size_t>(nodes));
    // Postordering is left to the analysis, which does it with all rows.
    if (!cholmod_metis(&graph, nullptr, 0, 0, order.data(), &common)) std::iota(order.begin(), order.end(), 0);
    return order;
}

/// Three rows for every node, in the nodes' order.
std::vector<int> expand(const std::vector<int>& node_order) {
    std::vector<int> order;
    for (int node : node_order)
        for (int c = 0; c < 3; ++c) order.push_back(3 * node + c);
    return order;
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

Pivot find_weakest(const cholmod_factor& factor, const Eigen::SparseMatrix<double>& k) {
    const auto* permutation = static_cast<const int*>(factor.Perm);
    if (factor.minor < factor.n) return {permutation[factor.minor], 0.0};
    Pivot weakest{0, 2.0};
    for_each_pivot(factor, [&](int j, double pivot) {
        const int row = permutation[j];
        const double ratio = pivot * pivot / k.coeff(row, row);
        if (!(ratio >= weakest.ratio)) weakest = {row, ratio};
    });
    return weakest;
}

}  // namespace

Factor::Factor(const Eigen::SparseMatrix<double>& k, PatternOnly) : state_(std::make_unique<State>()) {
    if (k.rows() % 3 != 0) throw Error(fmt::format("K has {} rows, and three a node are expected", k.rows()));
    openblas_set_num_threads(1);
    cholmod_sparse a = view(k);
    std::vector<int> order = expand(order_nodes(k, state_->common));
    state_->require(state_->common.status == CHOLMOD_OK, "ordering of K");
    state_->factor = cholmod_analyze_p(&a, order.data(), nullptr, 0, &state_->common);
    state_->require(state_->factor != nullptr, "analysis of K");
}

Factor::Factor(const Eigen::SparseMatrix<double>& k) : Factor(k, kPattern) {
    Workers alone(1);
    Progress silent(true);
    factorize(k, alone, silent);
}

void Factor::factorize(const Eigen::SparseMatrix<double>& k, Workers& workers, Progress& progress) {
    // Takes the memory of a numeric factor and leaves its numbers open.
    const int ok = cholmod_change_factor(CHOLMOD_REAL, 1, 1, 1, 1, state_->factor, &state_->common);
    state_->require(ok != 0, "factorisation of K");
    const std::int32_t stopped =
        haptable::factorize(supernodes(), k, static_cast<double*>(state_->factor->x), workers, progress);
    state_->factor->minor = stopped < 0 ? state_->factor->n : at(stopped);
    state_->weakest = find_weakest(*state_->factor, k);
}

Factor::~Factor() = default;

Eigen::Index Factor::size() const { return static_cast<Eigen::Index>(state_->factor->n); }

void Factor::solve(const Eigen::MatrixXd& b, Eigen::MatrixXd& x) const {
    cholmod_dense right = view(b);
    const int ok = cholmod_solve2(CHOLMOD_A, state_->factor, &right, nullptr, &state_->x, nullptr, &state_->y,
                                  &state_->e, &state_->common);
    state_->require(ok != 0, "solve");
    x.resize(b.rows(), b.cols());
    std::memcpy(x.data(), state_->x->x, static_cast<std::size_t>(b.size()) * sizeof(double));
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
            ints(factor.Perm, factor.n),           static_cast<const double*>(factor.x)};
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
