// SPDX-License-Identifier: GPL-2.0-or-later
// Y = L_RJ L_JJ^-1,   Z_RJ = -Z_RR Y,   Z_JJ = (L_JJ L_JJ^T)^-1 - Y^T Z_RJ,   Z = (L L^T)^-1
//
// Takahashi, Fagan and Chen's recurrence over supernodes, from the root of the elimination tree to its leaves: J are
// the columns of one supernode and R its rows below, all of which belong to its ancestors. The sweep is multifrontal:
// each supernode has a dense front Z_{JR,JR}; its children copy their Z_RR out of it, and the last of them frees it. So
// Z as a whole never exists, and the fronts of one path of the tree are all that is held.
#include "host/precompute/selected_inversion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <numeric>

#include "host/base/error.hpp"
#include "host/precompute/blas.hpp"

namespace haptable {

namespace {

/// Place of `row` among the ascending rows of a supernode, or -1.
std::int32_t find_row(std::span<const int> rows, int row) {
    const auto at = std::lower_bound(rows.begin(), rows.end(), row);
    return at != rows.end() && *at == row ? static_cast<std::int32_t>(at - rows.begin()) : -1;
}

std::size_t square(std::size_t n) { return n * n; }

/// Multiplications and additions of one supernode: triangular solve, symmetric product, inverse, lower half of Y^T Z.
double recurrence_flops(double columns, double below) {
    return columns * columns * below + 2.0 * below * below * columns + 2.0 / 3.0 * columns * columns * columns +
           columns * columns * below;
}

/// The fronts and the work of one sweep in precision T.
template <typename T>
class Sweep {
public:
    explicit Sweep(const Supernodes& factor) : factor_(factor), front_(static_cast<std::size_t>(factor.count())) {}

    /// Computes the front of supernode s from that of its parent, which must exist unless s is a root.
    void compute(std::int32_t s, std::int32_t parent) {
        const auto rows = static_cast<int>(factor_.rows(s).size());
        const int columns = factor_.column_count(s), below = rows - columns;
        auto& front = front_[static_cast<std::size_t>(s)];
        front = std::make_unique_for_overwrite<T[]>(square(static_cast<std::size_t>(rows)));
        T* z_jj = front.get();
        T* z_rj = z_jj + columns;
        T* z_rr = z_rj + static_cast<std::ptrdiff_t>(columns) * rows;
        if (below > 0) {
            gather(s, parent, z_rr, rows);
            const T* y = divide(s);
            blas::symm_lower(below, columns, T(-1), z_rr, rows, y, below, z_rj, rows);
        }
        copy_diagonal(s, z_jj, rows);
        if (blas::potri_lower(columns, z_jj, rows) != 0)
            throw Error("the factor of K has a pivot of 0; please report this mesh");
        if (below > 0) add_lower_product(columns, below, z_rj, z_jj, rows);
    }
    T at(std::int32_t s, std::int32_t row, std::int32_t column) const {
        const std::size_t rows = factor_.rows(s).size();
        return front_[static_cast<std::size_t>(s)]
                     [static_cast<std::size_t>(column) * rows + static_cast<std::size_t>(row)];
    }
    void free(std::int32_t s) { front_[static_cast<std::size_t>(s)].reset(); }

private:
    /// A stretch of rows of a supernode that are neighbours in its parent too.
    struct Run {
        int begin, end, source;
    };

    /// Where the rows below of s are in its parent's front. Both lists ascend.
    void find_runs(std::int32_t s, std::int32_t parent) {
        const std::span<const int> below = factor_.rows(s).subspan(static_cast<std::size_t>(factor_.column_count(s)));
        const std::span<const int> rows = factor_.rows(parent);
        run_.clear();
        int source = 0;
        for (int i = 0; i < static_cast<int>(below.size()); ++i, ++source) {
            const int before = source;
            while (rows[static_cast<std::size_t>(source)] != below[static_cast<std::size_t>(i)]) ++source;
            if (i == 0 || source != before) run_.push_back({i, i, source});
            run_.back().end = i + 1;
        }
    }

    /// The lower triangle of Z_RR out of the parent's front.
    void gather(std::int32_t s, std::int32_t parent, T* z_rr, int rows) {
        find_runs(s, parent);
        const T* source = front_[static_cast<std::size_t>(parent)].get();
        const auto source_rows = static_cast<std::ptrdiff_t>(factor_.rows(parent).size());
        for (std::size_t r = 0; r < run_.size(); ++r)
            for (int j = run_[r].begin; j < run_[r].end; ++j) {
                const T* from = source + source_rows * (run_[r].source + j - run_[r].begin);
                T* to = z_rr + static_cast<std::ptrdiff_t>(rows) * j;
                std::copy(from + run_[r].source + j - run_[r].begin,
                          from + run_[r].source + run_[r].end - run_[r].begin, to + j);
                for (std::size_t q = r + 1; q < run_.size(); ++q)
                    std::copy(from + run_[q].source, from + run_[q].source + run_[q].end - run_[q].begin,
                              to + run_[q].begin);
            }
    }

    /// Y = L_RJ L_JJ^-1, [below, columns]; L stays as it is.
    const T* divide(std::int32_t s) {
        const std::ptrdiff_t rows = static_cast<std::ptrdiff_t>(factor_.rows(s).size());
        const std::ptrdiff_t columns = factor_.column_count(s), below = rows - columns;
        const double* l = factor_.values(s);
        y_.resize(static_cast<std::size_t>(below * columns));
        l_jj_.resize(static_cast<std::size_t>(columns * columns));
        for (std::ptrdiff_t j = 0; j < columns; ++j) {
            const double* column = l + j * rows;
            for (std::ptrdiff_t i = j; i < columns; ++i)
                l_jj_[static_cast<std::size_t>(i + j * columns)] = static_cast<T>(column[i]);
            for (std::ptrdiff_t i = 0; i < below; ++i)
                y_[static_cast<std::size_t>(i + j * below)] = static_cast<T>(column[columns + i]);
        }
        blas::trsm_lower('R', 'N', static_cast<int>(below), static_cast<int>(columns), l_jj_.data(),
                         static_cast<int>(columns), y_.data(), static_cast<int>(below));
        return y_.data();
    }

    void copy_diagonal(std::int32_t s, T* z_jj, int rows) const {
        const double* l = factor_.values(s);
        for (std::ptrdiff_t j = 0; j < factor_.column_count(s); ++j)
            for (std::ptrdiff_t i = j; i < factor_.column_count(s); ++i)
                z_jj[i + j * rows] = static_cast<T>(l[i + j * rows]);
    }

    /// Z_JJ -= Y^T Z_RJ, the lower triangle in panels.
    void add_lower_product(int columns, int below, const T* z_rj, T* z_jj, int rows) const {
        constexpr int kPanel = 96;  // wide enough for BLAS, and at most this much of the upper triangle in vain
        for (int j = 0; j < columns; j += kPanel) {
            const std::ptrdiff_t first = j;
            blas::gemm('T', 'N', columns - j, std::min(kPanel, columns - j), below, T(-1), y_.data() + first * below,
                       below, z_rj + first * rows, rows, T(1), z_jj + first * rows + first, rows);
        }
    }

    Supernodes factor_;
    std::vector<std::unique_ptr<T[]>> front_;
    std::vector<T> y_, l_jj_;
    std::vector<Run> run_;
};

}  // namespace

std::vector<char> find_in_pattern(const Supernodes& factor, std::span<const NodePair> wanted) {
    const std::vector<std::int32_t> place = factor.places(), owner = factor.owners();
    std::vector<char> inside;
    for (const NodePair& pair : wanted) {
        bool all = true;
        for (int entry = 0; entry < 9; ++entry) {
            const std::int32_t p = place[static_cast<std::size_t>(3 * pair.row + entry % 3)];
            const std::int32_t q = place[static_cast<std::size_t>(3 * pair.column + entry / 3)];
            const std::int32_t s = owner[static_cast<std::size_t>(std::min(p, q))];
            all = all && find_row(factor.rows(s), std::max(p, q)) >= 0;
        }
        inside.push_back(all ? 1 : 0);
    }
    return inside;
}

SelectedInversion::SelectedInversion(const Supernodes& factor, std::span<const NodePair> wanted)
    : factor_(factor), wanted_count_(wanted.size()), parent_(factor.parents()) {
    find_picks(wanted);
    find_needed();
    find_order();
    measure();
}

void SelectedInversion::find_picks(std::span<const NodePair> wanted) {
    const std::vector<std::int32_t> place = factor_.places(), owner = factor_.owners();
    for (std::size_t w = 0; w < wanted.size(); ++w)
        for (int entry = 0; entry < 9; ++entry) {
            const std::int32_t p = place[static_cast<std::size_t>(3 * wanted[w].row + entry % 3)];
            const std::int32_t q = place[static_cast<std::size_t>(3 * wanted[w].column + entry / 3)];
            const std::int32_t s = owner[static_cast<std::size_t>(std::min(p, q))];
            const std::int32_t row = find_row(factor_.rows(s), std::max(p, q));
            if (row < 0)
                throw Error(
                    fmt::format("unknown nodes {} and {}: their block of L lies outside the factor's pattern; "
                                "it needs a solve",
                                wanted[w].row, wanted[w].column));
            pick_.push_back({s, row, std::min(p, q) - factor_.first_column[static_cast<std::size_t>(s)],
                             static_cast<std::int32_t>(w), entry});
        }
    std::stable_sort(pick_.begin(), pick_.end(),
                     [](const Pick& a, const Pick& b) { return a.supernode < b.supernode; });
    pick_begin_.assign(parent_.size() + 1, 0);
    for (const Pick& pick : pick_) ++pick_begin_[static_cast<std::size_t>(pick.supernode) + 1];
    std::partial_sum(pick_begin_.begin(), pick_begin_.end(), pick_begin_.begin());
}

void SelectedInversion::find_needed() {
    needed_.assign(parent_.size(), 0);
    child_count_.assign(parent_.size(), 0);
    for (std::size_t s = 0; s < parent_.size(); ++s) {  // children come before their parents
        if (pick_begin_[s + 1] > pick_begin_[s]) needed_[s] = 1;
        if (!needed_[s] || parent_[s] < 0) continue;
        needed_[static_cast<std::size_t>(parent_[s])] = 1;
        ++child_count_[static_cast<std::size_t>(parent_[s])];
    }
}

void SelectedInversion::find_order() {
    // The child whose subtree needs the most memory comes last: by then its parent's front can go.
    std::vector<std::vector<std::int32_t>> children(parent_.size());
    std::vector<std::size_t> most(parent_.size(), 0);  // entries held at once by a subtree
    const auto less = [&](std::int32_t a, std::int32_t b) {
        return most[static_cast<std::size_t>(a)] < most[static_cast<std::size_t>(b)];
    };
    std::vector<std::int32_t> stack;
    for (std::size_t s = 0; s < parent_.size(); ++s) {
        if (!needed_[s]) continue;
        std::stable_sort(children[s].begin(), children[s].end(), less);
        const std::size_t own = square(factor_.rows(static_cast<std::int32_t>(s)).size());
        most[s] = own;
        for (std::int32_t child : children[s]) {
            const std::size_t first = square(factor_.rows(child).size());
            const std::size_t subtree = most[static_cast<std::size_t>(child)];
            most[s] = std::max(most[s], child == children[s].back() ? std::max(own + first, subtree) : own + subtree);
        }
        if (parent_[s] < 0)
            stack.push_back(static_cast<std::int32_t>(s));
        else
            children[static_cast<std::size_t>(parent_[s])].push_back(static_cast<std::int32_t>(s));
    }
    while (!stack.empty()) {
        const std::int32_t s = stack.back();
        stack.pop_back();
        order_.push_back(s);
        const auto& list = children[static_cast<std::size_t>(s)];
        stack.insert(stack.end(), list.rbegin(), list.rend());
    }
}

/// Walks through the sweep without doing it.
void SelectedInversion::measure() {
    std::vector<std::int32_t> left = child_count_;
    std::size_t held = 0;
    for (std::int32_t s : order_) {
        const std::size_t rows = factor_.rows(s).size();
        const auto columns = static_cast<std::size_t>(factor_.column_count(s));
        flops_ += recurrence_flops(static_cast<double>(columns), static_cast<double>(rows - columns));
        held += square(rows);
        most_entries_ = std::max(most_entries_, held + rows * columns);  // Y and L_JJ beside the fronts
        const std::int32_t parent = parent_[static_cast<std::size_t>(s)];
        if (parent >= 0 && --left[static_cast<std::size_t>(parent)] == 0) held -= square(factor_.rows(parent).size());
        if (left[static_cast<std::size_t>(s)] == 0) held -= square(rows);
    }
}

template <typename T>
std::vector<Eigen::Matrix3d> SelectedInversion::compute(Progress& progress) const {
    std::vector<Eigen::Matrix3d> block(wanted_count_);
    std::vector<std::int32_t> left = child_count_;
    Sweep<T> sweep(factor_);
    double done = 0.0;
    for (std::int32_t s : order_) {
        const auto at = static_cast<std::size_t>(s);
        const std::int32_t parent = parent_[at];
        sweep.compute(s, parent);
        for (std::size_t p = pick_begin_[at]; p < pick_begin_[at + 1]; ++p)
            block[static_cast<std::size_t>(pick_[p].block)](pick_[p].entry) =
                static_cast<double>(sweep.at(s, pick_[p].row, pick_[p].column));
        if (parent >= 0 && --left[static_cast<std::size_t>(parent)] == 0) sweep.free(parent);
        if (left[at] == 0) sweep.free(s);
        const int columns = factor_.column_count(s);
        done += recurrence_flops(columns, static_cast<double>(factor_.rows(s).size()) - columns);
        progress.done(done / flops_);
    }
    return block;
}

template std::vector<Eigen::Matrix3d> SelectedInversion::compute<double>(Progress&) const;
template std::vector<Eigen::Matrix3d> SelectedInversion::compute<float>(Progress&) const;

}  // namespace haptable
