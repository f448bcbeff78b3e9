// SPDX-License-Identifier: GPL-2.0-or-later
// Y = L_RJ L_JJ^-1,   Z_RJ = -Z_RR Y,   Z_JJ = (L_JJ S L_JJ^T)^-1 - Y^T Z_RJ,   Z = (L S L^T)^-1
//
// Takahashi, Fagan and Chen's recurrence over supernodes, from the root of the elimination tree to its leaves: J are
// the columns of one supernode and R its rows below, all of which belong to its ancestors. The sweep is multifrontal:
// each supernode has a dense front Z_{JR,JR}; its children copy their Z_RR out of it, and the last of them frees it. So
// Z as a whole never exists, and the fronts of one path of the tree are all that is held.
#include "host/inverse/selected_inversion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <numeric>

#include "host/base/error.hpp"
#include "host/inverse/buffer.hpp"
#include "host/inverse/numeric.hpp"
#include "host/inverse/solve/blas.hpp"

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

/// L_JJ and Y, beside the front.
std::size_t work_entries(std::size_t rows, std::size_t columns) { return rows * columns; }

constexpr int kWhole = 256;  // columns of a diagonal block that LAPACK inverts as a whole

constexpr int kInverse = 384;  // columns of a larger one that a thread takes at a time

/// Columns of a symmetric product that a thread takes at a time: two parts or more where it pays, but wide ones, for
/// each packs the whole matrix once.
int symmetric_panel(int columns) {
    if (columns <= kWhole) return columns;
    const int halves = (columns + 1023) / 1024;
    return (columns + 2 * halves - 1) / (2 * halves);
}

std::size_t parts(int length, int part) { return static_cast<std::size_t>((length + part - 1) / part); }

/// The fronts and the work of one sweep in precision T. What threads share are panels of fixed widths, so that their
/// number changes no bit.
template <typename T>
class Sweep {
public:
    /// shared_stack, own_stack: entries that supernodes need which the workers share, and those of one worker alone.
    Sweep(const Supernodes& factor, int workers, std::size_t shared_stack, std::size_t own_stack)
        : factor_(factor), front_(static_cast<std::size_t>(factor.count())), shared_(shared_stack) {
        for (int worker = 0; worker < workers; ++worker)
            own_.push_back({nullptr, nullptr, {}, TwoStacks<T>(own_stack)});
    }

    /// Computes the front of supernode s from that of its parent, which must exist unless s is a root; with
    /// `free_parent` the parent's front is gone as soon as it is copied from. `workers` share the work and the stack of
    /// fronts; one `alone` works in memory of its own.
    void compute(std::int32_t s, std::int32_t parent, bool free_parent, Workers& workers, int worker, bool alone) {
        const Shape shape = shape_of(s);
        Own& own = own_[static_cast<std::size_t>(worker)];
        T* z_jj = make_front(s, parent, free_parent, alone ? own.stack : shared_);
        T* z_rj = z_jj + shape.columns;
        T* z_rr = z_rj + static_cast<std::ptrdiff_t>(shape.columns) * shape.rows;
        if (shape.below > 0) gather(s, parent, z_rr, workers, own);
        if (free_parent) free(parent);
        const Front& front = front_[static_cast<std::size_t>(s)];
        const std::size_t work =
            work_entries(static_cast<std::size_t>(shape.rows), static_cast<std::size_t>(shape.columns));
        own.l_jj = front.stack->push(front.end, work);
        own.y = own.l_jj + square(static_cast<std::size_t>(shape.columns));
        copy_diagonal(s, workers, own);
        if (shape.below > 0) {
            divide(s, workers, own);
            multiply(shape, z_rr, z_rj, workers, own);
        }
        invert_diagonal(shape, z_jj, workers, own);
        if (shape.below > 0) add_lower_product(shape, z_rj, z_jj, workers, own);
        front.stack->pop(front.end, work);
    }
    T at(std::int32_t s, std::int32_t row, std::int32_t column) const {
        const std::size_t rows = factor_.rows(s).size();
        return front_[static_cast<std::size_t>(s)]
            .value[static_cast<std::size_t>(column) * rows + static_cast<std::size_t>(row)];
    }
    /// All descendants' fronts on the same stack must be gone.
    void free(std::int32_t s) {
        const Front& front = front_[static_cast<std::size_t>(s)];
        front.stack->pop(front.end, square(factor_.rows(s).size()));
    }

private:
    /// A stretch of rows of a supernode that are neighbours in its parent too.
    struct Run {
        int begin, end, source;
    };
    struct Shape {
        int rows, columns, below, positive;
    };
    /// What a worker works on: L_JJ and Y at the top of a stack; and its own stack.
    struct Own {
        T *l_jj, *y;
        std::vector<Run> run;
        TwoStacks<T> stack;
    };
    struct Front {
        T* value = nullptr;
        TwoStacks<T>* stack = nullptr;
        int end = 0;
    };

    /// A last child lies on the other stack than its parent, which can then go: what lay above the parent on its own
    /// stack were descendants, which are done.
    T* make_front(std::int32_t s, std::int32_t parent, bool last, TwoStacks<T>& stack) {
        Front& front = front_[static_cast<std::size_t>(s)];
        front.stack = &stack;
        front.end = last ? 1 - front_[static_cast<std::size_t>(parent)].end : 0;
        if (!last && parent >= 0) front.end = front_[static_cast<std::size_t>(parent)].end;
        return front.value = stack.push(front.end, square(factor_.rows(s).size()));
    }

    Shape shape_of(std::int32_t s) const {
        const int rows = static_cast<int>(factor_.rows(s).size()), columns = factor_.column_count(s);
        return {rows, columns, rows - columns, factor_.positive_count(s)};
    }

    /// Where the rows below of s are in its parent's front. Both lists ascend.
    void find_runs(std::int32_t s, std::int32_t parent, std::vector<Run>& run) const {
        const std::span<const int> below = factor_.rows(s).subspan(static_cast<std::size_t>(factor_.column_count(s)));
        const std::span<const int> rows = factor_.rows(parent);
        run.clear();
        int source = 0;
        for (int i = 0; i < static_cast<int>(below.size()); ++i, ++source) {
            const int before = source;
            while (rows[static_cast<std::size_t>(source)] != below[static_cast<std::size_t>(i)]) ++source;
            if (i == 0 || source != before) run.push_back({i, i, source});
            run.back().end = i + 1;
        }
    }

    /// The lower triangle of Z_RR out of the parent's front.
    void gather(std::int32_t s, std::int32_t parent, T* z_rr, Workers& workers, Own& own) {
        const Shape shape = shape_of(s);
        find_runs(s, parent, own.run);
        workers.for_each(parts(shape.below, kThreadColumns), [&](std::size_t p, int) {
            const int begin = static_cast<int>(p) * kThreadColumns, end = std::min(shape.below, begin + kThreadColumns);
            for (std::size_t r = 0; r < own.run.size(); ++r)
                for (int j = std::max(begin, own.run[r].begin); j < std::min(end, own.run[r].end); ++j)
                    gather_column(parent, own.run, r, j, z_rr + static_cast<std::ptrdiff_t>(shape.rows) * j);
        });
    }

    void gather_column(std::int32_t parent, const std::vector<Run>& run, std::size_t r, int j, T* to) const {
        const auto source_rows = static_cast<std::ptrdiff_t>(factor_.rows(parent).size());
        const int column = run[r].source + j - run[r].begin;
        const T* from = front_[static_cast<std::size_t>(parent)].value + source_rows * column;
        std::copy(from + column, from + run[r].source + run[r].end - run[r].begin, to + j);
        for (std::size_t q = r + 1; q < run.size(); ++q)
            std::copy(from + run[q].source, from + run[q].source + run[q].end - run[q].begin, to + run[q].begin);
    }

    /// L_JJ, its lower triangle, in precision T.
    void copy_diagonal(std::int32_t s, Workers& workers, Own& own) const {
        const Shape shape = shape_of(s);
        const std::ptrdiff_t columns = shape.columns, rows = shape.rows;
        T* l_jj = own.l_jj;
        workers.for_each(parts(shape.columns, kThreadColumns), [&](std::size_t p, int) {
            const std::ptrdiff_t begin = static_cast<std::ptrdiff_t>(p) * kThreadColumns;
            for (std::ptrdiff_t j = begin; j < std::min(columns, begin + kThreadColumns); ++j) {
                const double* l = factor_.values(s) + j * rows;
                for (std::ptrdiff_t i = j; i < columns; ++i) l_jj[i + j * columns] = static_cast<T>(l[i]);
            }
        });
    }

    /// Y = L_RJ L_JJ^-1, [below, columns]; L stays as it is.
    void divide(std::int32_t s, Workers& workers, Own& own) {
        const Shape shape = shape_of(s);
        const std::ptrdiff_t below = shape.below;
        T* y = own.y;
        workers.for_each(parts(shape.below, kThreadRows), [&](std::size_t p, int) {
            const int begin = static_cast<int>(p) * kThreadRows, count = std::min(kThreadRows, shape.below - begin);
            for (std::ptrdiff_t j = 0; j < shape.columns; ++j) {
                const double* l = factor_.values(s) + j * shape.rows + shape.columns + begin;
                for (std::ptrdiff_t i = 0; i < count; ++i) y[begin + i + j * below] = static_cast<T>(l[i]);
            }
            blas::trsm_lower('R', 'N', count, shape.columns, own.l_jj, shape.columns, y + begin, shape.below);
        });
    }

    /// Z_RJ = -Z_RR Y.
    void multiply(const Shape& shape, const T* z_rr, T* z_rj, Workers& workers, const Own& own) const {
        const int panel = symmetric_panel(shape.columns);
        workers.for_each(parts(shape.columns, panel), [&](std::size_t p, int) {
            const int begin = static_cast<int>(p) * panel, count = std::min(panel, shape.columns - begin);
            blas::symm_lower(shape.below, count, T(-1), z_rr, shape.rows,
                             own.y + static_cast<std::ptrdiff_t>(begin) * shape.below, shape.below,
                             z_rj + static_cast<std::ptrdiff_t>(begin) * shape.rows, shape.rows);
        });
    }

    /// The lower triangle of Z_JJ = (L_JJ S L_JJ^T)^-1; L_JJ is lost.
    void invert_diagonal(const Shape& shape, T* z_jj, Workers& workers, Own& own) const {
        const int n = shape.columns, positive = shape.positive;
        const std::ptrdiff_t ldz = shape.rows, ldl = n;
        T* l_jj = own.l_jj;
        if (n <= kWhole && positive == n) {
            if (blas::potri_lower(n, l_jj, n) != 0)
                throw Error("the factor of K has a pivot of 0; please report this mesh");
        } else {
            // W = L_JJ^-1, a panel of columns at a time, into Z_JJ; then W^T S W over L_JJ.
            workers.for_each(parts(n, kInverse), [&](std::size_t p, int) {
                const int j = static_cast<int>(p) * kInverse, width = std::min(kInverse, n - j);
                T* w = z_jj + j + j * ldz;
                for (int c = 0; c < width; ++c) {
                    std::fill_n(w + c * ldz, n - j, T(0));
                    w[c + c * ldz] = T(1);
                }
                blas::trsm_lower('L', 'N', n - j, width, l_jj + j + j * ldl, n, w, shape.rows);
            });
            workers.for_each(parts(n, kInverse), [&](std::size_t p, int) {
                const int j = static_cast<int>(p) * kInverse, width = std::min(kInverse, n - j);
                for (int i = j; i < n; i += kInverse) {
                    const int height = std::min(kInverse, n - i), split = std::max(i, positive);
                    const auto add = [&](T sign, int begin, int end, T keep) {
                        blas::gemm('T', 'N', height, width, end - begin, sign, z_jj + begin + i * ldz, shape.rows,
                                   z_jj + begin + j * ldz, shape.rows, keep, l_jj + i + j * ldl, n);
                    };
                    add(T(1), i, split, T(0));
                    if (split < n) add(T(-1), split, n, T(1));
                }
            });
        }
        workers.for_each(parts(n, kThreadColumns), [&](std::size_t p, int) {
            const int begin = static_cast<int>(p) * kThreadColumns;
            for (std::ptrdiff_t j = begin; j < std::min(n, begin + kThreadColumns); ++j)
                std::copy(l_jj + j + j * ldl, l_jj + n + j * ldl, z_jj + j + j * ldz);
        });
    }

    /// Z_JJ -= Y^T Z_RJ, the lower triangle in panels: at most a panel's square of the upper one in vain.
    void add_lower_product(const Shape& shape, const T* z_rj, T* z_jj, Workers& workers, const Own& own) const {
        workers.for_each(parts(shape.columns, kThreadColumns), [&](std::size_t p, int) {
            const int j = static_cast<int>(p) * kThreadColumns;
            const std::ptrdiff_t first = j;
            blas::gemm('T', 'N', shape.columns - j, std::min(kThreadColumns, shape.columns - j), shape.below, T(-1),
                       own.y + first * shape.below, shape.below, z_rj + first * shape.rows, shape.rows, T(1),
                       z_jj + first * shape.rows + first, shape.rows);
        });
    }

    Supernodes factor_;
    std::vector<Front> front_;
    TwoStacks<T> shared_;
    std::vector<Own> own_;
};

/// Where the two unknowns of entry 0 to 8 of a pair's block, column by column, stand in the factor.
std::pair<std::int32_t, std::int32_t> places_of(const std::vector<std::int32_t>& place, const NodePair& pair,
                                                int entry) {
    const auto at = [&](std::int32_t node, int axis) {
        return place[3 * static_cast<std::size_t>(node) + static_cast<std::size_t>(axis)];
    };
    return {at(pair.row, entry % 3), at(pair.column, entry / 3)};
}

}  // namespace

std::vector<char> find_in_pattern(const Supernodes& factor, std::span<const NodePair> wanted) {
    const std::vector<std::int32_t> place = factor.places(), owner = factor.owners();
    std::vector<char> inside;
    for (const NodePair& pair : wanted) {
        bool all = true;
        for (int entry = 0; entry < 9; ++entry) {
            const auto [p, q] = places_of(place, pair, entry);
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
            const auto [p, q] = places_of(place, wanted[w], entry);
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
        const auto node = static_cast<std::int32_t>(s);
        most[s] = own + work_entries(factor_.rows(node).size(), static_cast<std::size_t>(factor_.column_count(node)));
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
    subtree_entries_ = std::move(most);
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
    flops_of_.assign(parent_.size(), 0.0);
    for (std::int32_t s : order_) {
        const std::size_t rows = factor_.rows(s).size();
        const auto columns = static_cast<std::size_t>(factor_.column_count(s));
        flops_ += flops_of_[static_cast<std::size_t>(s)] =
            recurrence_flops(static_cast<double>(columns), static_cast<double>(rows - columns));
        held += square(rows);
        most_entries_ = std::max(most_entries_, held);
        const std::int32_t parent = parent_[static_cast<std::size_t>(s)];
        if (parent >= 0 && --left[static_cast<std::size_t>(parent)] == 0) held -= square(factor_.rows(parent).size());
        most_entries_ = std::max(most_entries_, held + work_entries(rows, columns));
        if (left[static_cast<std::size_t>(s)] == 0) held -= square(rows);
    }
}

/// Most entries that a small subtree holds at once, when `workers` take them one by one.
std::size_t SelectedInversion::small_entries(int workers) const {
    const std::vector<std::int32_t> subtree = find_subtrees(parent_, flops_of_, workers);
    std::size_t most = 0;
    for (std::int32_t s : order_)
        if (subtree[static_cast<std::size_t>(s)] == s)
            most = std::max(most, subtree_entries_[static_cast<std::size_t>(s)]);
    return most;
}

std::size_t SelectedInversion::stack_entries(int workers) const {
    return most_entries_ + (workers == 1 ? 0 : static_cast<std::size_t>(workers) * small_entries(workers));
}

template <typename T>
class SelectedInversion::Run {
public:
    Run(const SelectedInversion& plan, Progress& progress, Workers& workers)
        : plan_(plan),
          progress_(progress),
          workers_(workers),
          subtree_(find_subtrees(plan.parent_, plan.flops_of_, workers.count())),
          left_(plan.child_count_),
          sweep_(plan.factor_, workers.count(), workers.count() == 1 ? 0 : plan.most_entries_,
                 plan.small_entries(workers.count())),
          block_(plan.wanted_count_) {
        find_subtree_ranges();
    }

    std::vector<Eigen::Matrix3d> compute() {
        below(-1);
        for (std::int32_t s : plan_.order_) {
            if (subtree_[at(s)] >= 0) continue;
            step(s, workers_, 0, false, true);
            release_parent(s);
            below(s);
            if (left_[at(s)] == 0) sweep_.free(s);
        }
        return std::move(block_);
    }

private:
    /// Part of the order that is one small subtree: postorder and the order of the sweep both keep it together.
    struct Range {
        std::size_t begin, end;
    };

    void find_subtree_ranges() {
        small_.resize(plan_.parent_.size() + 1);
        const std::vector<std::int32_t>& order = plan_.order_;
        for (std::size_t i = 0; i < order.size();) {
            const std::int32_t root = subtree_[at(order[i])];
            std::size_t end = i + 1;
            while (root >= 0 && end < order.size() && subtree_[at(order[end])] == root) ++end;
            if (root >= 0) small_[at(plan_.parent_[at(order[i])] + 1)].push_back({i, end});
            i = end;
        }
    }

    /// All small subtrees right below s (-1: whole trees), side by side.
    void below(std::int32_t s) {
        const std::vector<Range>& ranges = small_[at(s + 1)];
        workers_.for_each(ranges.size(), [&](std::size_t r, int worker) {
            Workers alone(1);
            for (std::size_t i = ranges[r].begin; i < ranges[r].end; ++i) {
                const std::int32_t node = plan_.order_[i];
                step(node, alone, worker, true, i > ranges[r].begin);
                if (i > ranges[r].begin) release_parent(node);
                if (left_[at(node)] == 0) sweep_.free(node);
            }
        });
        if (s >= 0) left_[at(s)] -= static_cast<std::int32_t>(ranges.size());
    }

    void release_parent(std::int32_t s) {
        const std::int32_t parent = plan_.parent_[at(s)];
        if (parent >= 0) --left_[at(parent)];
    }

    void step(std::int32_t s, Workers& workers, int worker, bool alone, bool may_free_parent) {
        const std::int32_t parent = plan_.parent_[at(s)];
        const bool last = may_free_parent && parent >= 0 && left_[at(parent)] == 1;
        sweep_.compute(s, parent, last, workers, worker, alone);
        for (std::size_t p = plan_.pick_begin_[at(s)]; p < plan_.pick_begin_[at(s) + 1]; ++p) {
            const Pick& pick = plan_.pick_[p];
            block_[at(pick.block)](pick.entry) = static_cast<double>(sweep_.at(s, pick.row, pick.column));
        }
        const std::lock_guard lock(mutex_);
        progress_.done((done_ += plan_.flops_of_[at(s)]) / plan_.flops_);
    }

    const SelectedInversion& plan_;
    Progress& progress_;
    Workers& workers_;
    std::vector<std::int32_t> subtree_, left_;
    std::vector<std::vector<Range>> small_;  // [supernodes + 1] below supernode s - 1
    Sweep<T> sweep_;
    std::vector<Eigen::Matrix3d> block_;
    std::mutex mutex_;
    double done_ = 0.0;
};

template <typename T>
std::vector<Eigen::Matrix3d> SelectedInversion::compute(Progress& progress, Workers* workers) const {
    Workers alone(1);
    return Run<T>(*this, progress, workers != nullptr ? *workers : alone).compute();
}

template std::vector<Eigen::Matrix3d> SelectedInversion::compute<double>(Progress&, Workers*) const;
template std::vector<Eigen::Matrix3d> SelectedInversion::compute<float>(Progress&, Workers*) const;

}  // namespace haptable
