// SPDX-License-Identifier: GPL-2.0-or-later
// L_J = (M_J - sum over the descendants D of L_RD S L_JD^T) L_JJ^-T S,   L_JJ S L_JJ^T = the same at the rows J
//
// Left-looking over supernodes (Ng and Peyton 1993): a supernode takes what its descendants owe it and is then
// factorised as a dense matrix. Beside the factor itself only one product is held. The columns J are cut into panels of
// a fixed width, and rows into stretches of a fixed length: those are what threads share, so that the sums are the same
// for any number of them. Small subtrees go to a thread as a whole.
#include "host/inverse/numeric.hpp"

#include <algorithm>
#include <atomic>
#include <limits>
#include <mutex>
#include <numeric>

#include "host/inverse/solve/blas.hpp"

namespace haptable {

namespace {

struct NotPositive {
    std::int32_t column;
};

class Factorization {
public:
    Factorization(const Supernodes& pattern, const Eigen::SparseMatrix<double>& m, double* value, Workers& workers,
                  Progress& progress)
        : pattern_(pattern),
          m_(m),
          value_(value),
          workers_(workers),
          progress_(progress),
          parent_(pattern.parents()),
          place_(pattern.places()),
          own_(at(workers.count())) {
        find_descendants();
        for (std::int32_t s = 0; s < pattern_.count(); ++s) cost_.push_back(cost(s));
        total_ = std::accumulate(cost_.begin(), cost_.end(), 0.0);
    }

    std::int32_t run() {
        const std::vector<std::int32_t> subtree = find_subtrees(parent_, cost_, workers_.count());
        std::vector<std::int32_t> root, first;  // of every subtree: postorder keeps it together
        for (std::int32_t s = 0; s < pattern_.count(); ++s)
            if (subtree[at(s)] >= 0) {
                if (s == 0 || subtree[at(s)] != subtree[at(s - 1)]) first.push_back(s);
                if (subtree[at(s)] == s) root.push_back(s);
            }
        workers_.for_each(root.size(), [&](std::size_t t, int worker) {
            Workers alone(1);
            for (std::int32_t s = first[t]; s <= root[t]; ++s) compute(s, alone, worker);
        });
        for (std::int32_t s = 0; s < pattern_.count() && failed_ == kNone; ++s)
            if (subtree[at(s)] < 0) compute(s, workers_, 0);
        return failed_ == kNone ? -1 : failed_.load();
    }

private:
    static constexpr std::int32_t kNone = std::numeric_limits<std::int32_t>::max();

    /// Rows of a descendant from `begin` on belong to the supernode or to its ancestors.
    struct Debt {
        std::int32_t descendant, begin;
    };
    /// A worker's own memory.
    struct Own {
        std::vector<double> product;
        std::vector<std::int32_t> local;
    };

    double cost(std::int32_t s) const {
        const double columns = pattern_.column_count(s), rows = static_cast<double>(pattern_.rows(s).size());
        const double below = rows - columns;
        return columns * columns * columns / 3.0 + columns * below * (columns + below);
    }

    template <typename Visit>
    void for_each_debt(const std::vector<std::int32_t>& owner, Visit visit) const {
        for (std::int32_t d = 0; d < pattern_.count(); ++d) {
            const std::span<const int> rows = pattern_.rows(d);
            std::int32_t last = d;
            for (std::size_t r = at(pattern_.column_count(d)); r < rows.size(); ++r)
                if (owner[at(rows[r])] != last) visit(last = owner[at(rows[r])], Debt{d, static_cast<std::int32_t>(r)});
        }
    }

    void find_descendants() {
        const std::vector<std::int32_t> owner = pattern_.owners();
        debt_begin_.assign(at(pattern_.count()) + 1, 0);
        for_each_debt(owner, [&](std::int32_t s, const Debt&) { ++debt_begin_[at(s) + 1]; });
        std::partial_sum(debt_begin_.begin(), debt_begin_.end(), debt_begin_.begin());
        debt_.resize(debt_begin_.back());
        std::vector<std::size_t> next = debt_begin_;
        for_each_debt(owner, [&](std::int32_t s, const Debt& debt) { debt_[next[at(s)]++] = debt; });
    }

    void compute(std::int32_t s, Workers& workers, int worker) {
        if (failed_ != kNone) return;
        const int columns = pattern_.column_count(s);
        const auto panels = static_cast<std::size_t>((columns + kThreadColumns - 1) / kThreadColumns);
        double* l = value_ + pattern_.value_begin[at(s)];
        // The upper triangle is never used: where it fills whole pages it takes no memory.
        const std::size_t rows = pattern_.rows(s).size();
        for (std::size_t j = 0; j < at(columns); ++j) std::fill_n(l + j * rows + j, rows - j, 0.0);
        workers.for_each(panels, [&](std::size_t p, int sharing) {
            Own& own = own_[at(workers.count() == 1 ? worker : sharing)];
            const int begin = static_cast<int>(p) * kThreadColumns, end = std::min(columns, begin + kThreadColumns);
            add_stiffness(s, begin, end, l);
            for (std::size_t d = debt_begin_[at(s)]; d < debt_begin_[at(s) + 1]; ++d)
                subtract(debt_[d], s, begin, end, l, own);
        });
        try {
            factorize_dense(s, workers, l);
        } catch (const NotPositive& failed) {
            for (std::int32_t least = failed_; failed.column < least;)
                if (failed_.compare_exchange_weak(least, failed.column)) break;
        }
        const std::lock_guard lock(mutex_);
        progress_.done((done_ += cost_[at(s)]) / total_);
    }

    /// Local row of a row of L in supernode s; it must be there.
    static std::int32_t find(std::span<const int> rows, int columns, int first, int row) {
        if (row < first + columns) return row - first;
        return static_cast<std::int32_t>(std::lower_bound(rows.begin() + columns, rows.end(), row) - rows.begin());
    }

    void add_stiffness(std::int32_t s, int begin, int end, double* l) const {
        const std::span<const int> rows = pattern_.rows(s);
        const int first = pattern_.first_column[at(s)];
        for (int j = begin; j < end; ++j) {
            const int column = pattern_.permutation[at(first + j)];
            for (int e = m_.outerIndexPtr()[column]; e < m_.outerIndexPtr()[column + 1]; ++e) {
                const std::int32_t row = place_[at(m_.innerIndexPtr()[e])];
                if (row >= first + j)
                    l[at(find(rows, pattern_.column_count(s), first, row)) + at(j) * rows.size()] = m_.valuePtr()[e];
            }
        }
    }

    /// The descendant's part of columns begin .. end - 1 of supernode s.
    void subtract(const Debt& debt, std::int32_t s, int begin, int end, double* l, Own& own) const {
        const std::span<const int> all = pattern_.rows(debt.descendant), target = pattern_.rows(s);
        const std::span<const int> rows = all.subspan(at(debt.begin));
        const int first = pattern_.first_column[at(s)];
        const auto from = std::lower_bound(rows.begin(), rows.end(), first + begin) - rows.begin();
        const auto to = std::lower_bound(rows.begin() + from, rows.end(), first + end) - rows.begin();
        if (from == to) return;
        const std::span<const int> height = rows.subspan(static_cast<std::size_t>(from));
        const int m = static_cast<int>(height.size()), n = static_cast<int>(to - from);
        const int lda = static_cast<int>(all.size());
        const double* d = value_ + pattern_.value_begin[at(debt.descendant)] + debt.begin + from;
        own.product.resize(std::max(own.product.size(), at(m) * at(n)));
        const int columns = pattern_.column_count(debt.descendant), positive = pattern_.positive_count(debt.descendant);
        blas::gemm('N', 'T', m, n, positive, 1.0, d, lda, d, lda, 0.0, own.product.data(), m);
        if (positive < columns) {
            const double* q = d + static_cast<std::ptrdiff_t>(positive) * lda;
            blas::gemm('N', 'T', m, n, columns - positive, -1.0, q, lda, q, lda, 1.0, own.product.data(), m);
        }
        locate(height, target, pattern_.column_count(s), first, own.local);
        for (int j = 0; j < n; ++j) {
            double* column = l + static_cast<std::size_t>(height[at(j)] - first) * target.size();
            const double* product = own.product.data() + at(j) * at(m);
            for (int i = j; i < m; ++i) column[own.local[at(i)]] -= product[i];
        }
    }

    /// local[i]: where rows[i] is among the target's rows. Both ascend.
    static void locate(std::span<const int> rows, std::span<const int> target, int columns, int first,
                       std::vector<std::int32_t>& local) {
        local.resize(std::max(local.size(), rows.size()));
        std::size_t i = 0;
        for (; i < rows.size() && rows[i] < first + columns; ++i) local[i] = rows[i] - first;
        const int* next = target.data() + columns;
        for (; i < rows.size(); ++i) {
            if (*next != rows[i]) next = std::lower_bound(next, target.data() + target.size(), rows[i]);
            local[i] = static_cast<std::int32_t>(next++ - target.data());
        }
    }

    /// L S L^T of the dense panels of one supernode, left-looking. In a panel all signs are alike.
    void factorize_dense(std::int32_t s, Workers& workers, double* l) const {
        const int rows = static_cast<int>(pattern_.rows(s).size()), columns = pattern_.column_count(s);
        const int positive = pattern_.positive_count(s);
        const auto stretches = [&](int begin) { return at((rows - begin + kThreadRows - 1) / kThreadRows); };
        for (int j = 0, width = 0; j < columns; j += width) {
            const bool is_positive = j < positive;
            width = std::min(kThreadColumns, (is_positive ? positive : columns) - j);
            double* diagonal = l + j + static_cast<std::ptrdiff_t>(j) * rows;
            // The panel less what earlier columns owe it, times its sign.
            const auto update = [&](std::size_t stretch, int) {
                const int r = j + static_cast<int>(stretch) * kThreadRows, m = std::min(kThreadRows, rows - r);
                const double sign = is_positive ? 1.0 : -1.0;
                const auto subtract_columns = [&](int begin, int end, double alpha, double keep) {
                    const double* q = l + static_cast<std::ptrdiff_t>(begin) * rows;
                    blas::gemm('N', 'T', m, width, end - begin, alpha, q + r, rows, q + j, rows, keep,
                               diagonal + (r - j), rows);
                };
                subtract_columns(0, std::min(j, positive), -sign, sign);
                if (j > positive) subtract_columns(positive, j, -1.0, 1.0);
            };
            if (j > 0 || !is_positive) workers.for_each(stretches(j), update);
            const int info = blas::potrf_lower(width, diagonal, rows);
            if (info > 0) throw NotPositive{pattern_.first_column[at(s)] + j + info - 1};
            const int end = j + width;
            const auto divide = [&](std::size_t stretch, int) {
                const int r = end + static_cast<int>(stretch) * kThreadRows, m = std::min(kThreadRows, rows - r);
                blas::trsm_lower('R', 'T', m, width, diagonal, rows, diagonal + (r - j), rows);
            };
            if (end < rows) workers.for_each(stretches(end), divide);
        }
    }

    Supernodes pattern_;
    const Eigen::SparseMatrix<double>& m_;
    double* value_;
    Workers& workers_;
    Progress& progress_;
    std::vector<std::int32_t> parent_, place_;
    std::vector<std::size_t> debt_begin_;  // [supernodes + 1]
    std::vector<Debt> debt_;               // by supernode, descendants ascending
    std::vector<double> cost_;
    std::vector<Own> own_;
    std::mutex mutex_;
    std::atomic<std::int32_t> failed_{kNone};
    double total_ = 0.0, done_ = 0.0;
};

}  // namespace

std::vector<std::int32_t> find_subtrees(const std::vector<std::int32_t>& parent, const std::vector<double>& cost,
                                        int workers) {
    std::vector<double> sum = cost;
    for (std::size_t s = 0; s < parent.size(); ++s)  // children come before their parents
        if (parent[s] >= 0) sum[at(parent[s])] += sum[s];
    const double most = std::accumulate(cost.begin(), cost.end(), 0.0) / (8.0 * workers);
    std::vector<std::int32_t> root(parent.size(), -1);
    for (std::size_t s = parent.size(); s-- > 0;) {
        if (workers > 1 && sum[s] > most) continue;
        const bool inner = parent[s] >= 0 && root[at(parent[s])] >= 0;
        root[s] = inner ? root[at(parent[s])] : static_cast<std::int32_t>(s);
    }
    return root;
}

std::int32_t factorize(const Supernodes& pattern, const Eigen::SparseMatrix<double>& m, double* value, Workers& workers,
                       Progress& progress) {
    return Factorization(pattern, m, value, workers, progress).run();
}

double factorize_bytes(const Supernodes& pattern, int workers) {
    double most = 0.0;
    for (std::int32_t s = 0; s < pattern.count(); ++s) {
        const double below = static_cast<double>(pattern.rows(s).size()) - pattern.column_count(s);
        most = std::max(most, below * std::min(below, static_cast<double>(kThreadColumns)));
    }
    return most * workers * sizeof(double);
}

}  // namespace haptable
