// SPDX-License-Identifier: GPL-2.0-or-later
// A_IJ ~ s_I (U_I core U_J^T) s_J,   U_I: largest eigenvectors of sum_J A_IJ A_IJ^T / tr
#include "host/compliance/pair_clusters.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "host/dense/dense.hpp"

namespace haptable {

namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr Eigen::Index kRows = 3 * kClusterPlaces;
constexpr std::size_t kScaleBytes = 4, kVectorBytes = 6, kCoreBytes = 9, kClusterBegin_bytes = 4;
/// The couplings of two clusters at the most.
using Tile = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kRows, kRows>;

constexpr double kBasisStep = 32767.0, kCoreSteps = 127.0, kFineSteps = 32767.0;
/// Where two places hardly differ, and in which E counts by so much more.
constexpr double kLeastApart = 1.0 / 128.0;
constexpr std::size_t kForms = kMostRank + 3;  // ranks from 0, dense, fine
constexpr std::size_t kDense = kMostRank + 1, kFine = kMostRank + 2;

std::size_t longest_axis(const PlaceMatrix& a, std::span<const std::size_t> part) {
    Vector3d low = a.position_m[part[0]], high = low;
    for (const std::size_t i : part) {
        low = low.cwiseMin(a.position_m[i]);
        high = high.cwiseMax(a.position_m[i]);
    }
    Eigen::Index axis = 0;
    (high - low).maxCoeff(&axis);
    return static_cast<std::size_t>(axis);
}

/// Halves along the longest side until each part is a cluster; all but the last are whole.
void bisect(const PlaceMatrix& a, std::span<std::size_t> part) {
    if (part.size() <= kClusterPlaces) return;
    const auto axis = static_cast<Eigen::Index>(longest_axis(a, part));
    std::sort(part.begin(), part.end(), [&](std::size_t i, std::size_t j) {
        const double x = a.position_m[i][axis], y = a.position_m[j][axis];
        return x != y ? x < y : i < j;
    });
    const std::size_t half = kClusterPlaces * ((cluster_count(part.size()) + 1) / 2);
    bisect(a, part.first(half));
    bisect(a, part.subspan(half));
}

/// A place of its own: its scale s, and (A_ii / s^2)^-1/2.
struct Own {
    double scale = 0.0;
    Matrix3d whiten = Matrix3d::Zero();
};

Own own_of(const Matrix3d& block) {
    Own own;
    own.scale = static_cast<double>(static_cast<float>(std::sqrt(block.norm() / std::sqrt(3.0))));
    if (own.scale == 0.0) return own;
    const SymmetricEigen eigen = symmetric_eigen(block / (own.scale * own.scale));
    const VectorXd root = eigen.values.cwiseMax(1e-12).cwiseSqrt().cwiseInverse();
    own.whiten = eigen.vectors * root.asDiagonal() * eigen.vectors.transpose();
    return own;
}

/// A cluster's places, and the basis that it shares: [3 k, r] in steps of 1 / 32767.
struct Cluster {
    std::vector<std::size_t> place;
    std::vector<Own> own;
    Tile basis;            // orthonormal columns
    Tile whitened;         // the same, each place's rows by its own whiten
    VectorXd column_size;  // which cores are divided by, 1 at the most
};

/// All forms of a pair of clusters: what each is off, and its numbers.
struct Forms {
    std::array<float, kForms> error{};
    std::vector<std::int8_t> core, dense;           // [r r], [.,8,9]
    std::vector<std::array<std::int16_t, 9>> fine;  // [.,8]
    double core_step = 1.0, dense_step = 1.0, fine_step = 1.0;
    Eigen::Index rank = 0;  // of core
};

class Clusters {
public:
    Clusters(const PlaceMatrix& a, std::vector<std::size_t>& order, Progress& progress) : a_(a), progress_(progress) {
        order.resize(a.position_m.size());
        std::iota(order.begin(), order.end(), std::size_t{0});
        bisect(a, order);
        for (std::size_t i = 0; i < order.size(); ++i) {
            if (i % kClusterPlaces == 0) cluster_.emplace_back();
            cluster_.back().place.push_back(order[i]);
        }
        measure_own();
        find_bases();
    }

    const std::vector<Cluster>& all() const { return cluster_; }

    /// Every pair I >= J in a row by I.
    void each(double from, double to, const std::function<void(std::size_t, std::size_t, const Forms&)>& take) {
        for (std::size_t i = 0; i < cluster_.size(); ++i) {
            progress_.done(from + (to - from) * static_cast<double>(i * i) /
                                      static_cast<double>(cluster_.size() * cluster_.size()));
            const MatrixXd rows = scaled_rows(i);
            for (std::size_t j = 0; j <= i; ++j) take(i, j, forms(i, j, tile(rows, j)));
        }
    }

private:
    void measure_own() {
        own_.resize(a_.position_m.size());
        for (Cluster& cluster : cluster_) {
            const MatrixXd rows = a_.rows(cluster.place);
            for (std::size_t i = 0; i < cluster.place.size(); ++i)
                cluster.own.push_back(own_of(rows.block<3, 3>(3 * static_cast<Eigen::Index>(i),
                                                              3 * static_cast<Eigen::Index>(cluster.place[i]))));
        }
        for (const Cluster& cluster : cluster_)
            for (std::size_t i = 0; i < cluster.place.size(); ++i) own_[cluster.place[i]] = cluster.own[i];
    }

    /// The rows of cluster i: A over s s^T.
    MatrixXd scaled_rows(std::size_t i) const {
        const Cluster& cluster = cluster_[i];
        MatrixXd rows = a_.rows(cluster.place);
        const auto inverse = [](double s) { return s > 0.0 ? 1.0 / s : 0.0; };
        for (std::size_t k = 0; k < cluster.place.size(); ++k)
            rows.middleRows<3>(3 * static_cast<Eigen::Index>(k)) *= inverse(cluster.own[k].scale);
        for (std::size_t l = 0; l < own_.size(); ++l)
            rows.middleCols<3>(3 * static_cast<Eigen::Index>(l)) *= inverse(own_[l].scale);
        return rows;
    }

    Tile tile(const MatrixXd& rows, std::size_t j) const {
        Tile to(rows.rows(), 3 * static_cast<Eigen::Index>(cluster_[j].place.size()));
        for (std::size_t l = 0; l < cluster_[j].place.size(); ++l)
            to.middleCols<3>(3 * static_cast<Eigen::Index>(l)) =
                rows.middleCols<3>(3 * static_cast<Eigen::Index>(cluster_[j].place[l]));
        return to;
    }

    void find_bases() {
        for (std::size_t i = 0; i < cluster_.size(); ++i) {
            progress_.done(0.2 * static_cast<double>(i) / static_cast<double>(cluster_.size()));
            const MatrixXd rows = scaled_rows(i);
            MatrixXd sum = MatrixXd::Zero(rows.rows(), rows.rows());
            for (std::size_t j = 0; j < cluster_.size(); ++j) {
                if (j == i) continue;
                const Tile a = tile(rows, j);
                const double size = a.squaredNorm();
                if (size > 0.0) sum.noalias() += (1.0 / size) * a * a.transpose();
            }
            set_basis(sum, cluster_[i]);
        }
    }

    /// In steps, largest first; a column's size is the root of how much of A it has.
    static void set_basis(const MatrixXd& sum, Cluster& cluster) {
        const SymmetricEigen eigen = symmetric_eigen(sum);
        const Eigen::Index rank = std::min<Eigen::Index>(kMostRank, sum.rows());
        cluster.basis.resize(sum.rows(), rank);
        cluster.column_size.resize(rank);
        const double most = std::max(eigen.values.tail<1>()[0], 1e-300);
        for (Eigen::Index r = 0; r < rank; ++r) {
            const Eigen::Index from = sum.rows() - 1 - r;
            cluster.column_size[r] = std::pow(std::max(eigen.values[from] / most, 1e-9), 0.25);
            cluster.basis.col(r) = eigen.vectors.col(from);
        }
        cluster.whitened = cluster.basis;
        for (std::size_t k = 0; k < cluster.place.size(); ++k) {
            auto rows = cluster.whitened.middleRows<3>(3 * static_cast<Eigen::Index>(k));
            rows = (cluster.own[k].whiten * rows).eval();
        }
    }

    Forms forms(std::size_t i, std::size_t j, const Tile& a) const {
        Forms to;
        const Tile whitened = whiten(cluster_[i], cluster_[j], a);
        const MatrixXd limit = limits(cluster_[i], cluster_[j], whitened);
        keep_dense(cluster_[i], cluster_[j], a, limit, to);
        if (i == j)
            std::fill_n(to.error.begin(), kMostRank + 1, HUGE_VALF);
        else
            keep_core(cluster_[i], cluster_[j], a, whitened, limit, to);
        return to;
    }

    /// What an error of each block is measured by.
    MatrixXd limits(const Cluster& one, const Cluster& two, const Tile& whitened) const {
        MatrixXd to(one.place.size(), two.place.size());
        for (Eigen::Index k = 0; k < to.rows(); ++k)
            for (Eigen::Index l = 0; l < to.cols(); ++l) {
                const auto [low, high] =
                    std::minmax(one.place[static_cast<std::size_t>(k)], two.place[static_cast<std::size_t>(l)]);
                to(k, l) =
                    a_.alike.contains({low, high})
                        ? kLeastApart
                        : std::max(kLeastApart, 1.0 - whitened.block<3, 3>(3 * k, 3 * l).norm() / std::sqrt(3.0));
            }
        return to;
    }

    /// A_ii^-1/2 E_ij A_jj^-1/2 of each block.
    static Tile whiten(const Cluster& one, const Cluster& two, const Tile& e) {
        Tile to(e.rows(), e.cols());
        for (std::size_t k = 0; k < one.place.size(); ++k)
            for (std::size_t l = 0; l < two.place.size(); ++l) {
                const auto row = 3 * static_cast<Eigen::Index>(k), column = 3 * static_cast<Eigen::Index>(l);
                to.block<3, 3>(row, column).noalias() =
                    one.own[k].whiten * Matrix3d(e.block<3, 3>(row, column) * two.own[l].whiten);
            }
        return to;
    }

    static float worst(const Tile& whitened, const MatrixXd& limit) {
        double most2 = 0.0;
        for (Eigen::Index k = 0; k < limit.rows(); ++k)
            for (Eigen::Index l = 0; l < limit.cols(); ++l)
                most2 = std::max(most2, whitened.block<3, 3>(3 * k, 3 * l).squaredNorm() / (limit(k, l) * limit(k, l)));
        return static_cast<float>(std::sqrt(most2));
    }

    static double step_of(double largest, double steps) {
        return largest > 0.0 ? static_cast<double>(static_cast<float>(largest / steps)) : 1.0;
    }
    template <typename Step>
    static Step in_steps(double value, double step) {
        constexpr long kMost = std::numeric_limits<Step>::max();
        return static_cast<Step>(std::clamp(std::lround(value / step), -kMost, kMost));
    }

    static void keep_dense(const Cluster& one, const Cluster& two, const Tile& a, const MatrixXd& limit, Forms& to) {
        const double largest = a.cwiseAbs().maxCoeff();
        const auto blocks = static_cast<std::size_t>(limit.rows()) * kClusterPlaces;
        to.dense_step = step_of(largest, kCoreSteps);
        to.fine_step = step_of(largest, kFineSteps);
        to.dense.assign(9 * blocks, 0);
        to.fine.assign(blocks, {});
        Tile e = a, e_fine = a;
        for (Eigen::Index k = 0; k < limit.rows(); ++k)
            for (Eigen::Index l = 0; l < limit.cols(); ++l)
                for (Eigen::Index c = 0; c < 9; ++c) {
                    const auto at = static_cast<std::size_t>(k) * kClusterPlaces + static_cast<std::size_t>(l);
                    const Eigen::Index row = 3 * k + c / 3, column = 3 * l + c % 3;
                    std::int8_t& dense = to.dense[9 * at + static_cast<std::size_t>(c)];
                    std::int16_t& fine = to.fine[at][static_cast<std::size_t>(c)];
                    dense = in_steps<std::int8_t>(a(row, column), to.dense_step);
                    fine = in_steps<std::int16_t>(a(row, column), to.fine_step);
                    e(row, column) -= dense * to.dense_step;
                    e_fine(row, column) -= fine * to.fine_step;
                }
        to.error[kDense] = worst(whiten(one, two, e), limit);
        to.error[kFine] = worst(whiten(one, two, e_fine), limit);
    }

    /// Cores of all ranks: each is the first rows and columns of the largest.
    static void keep_core(const Cluster& one, const Cluster& two, const Tile& a, const Tile& whitened,
                          const MatrixXd& limit, Forms& to) {
        to.rank = std::min(one.basis.cols(), two.basis.cols());
        MatrixXd core = one.basis.leftCols(to.rank).transpose() * a * two.basis.leftCols(to.rank);
        core = one.column_size.head(to.rank).cwiseInverse().asDiagonal() * core *
               two.column_size.head(to.rank).cwiseInverse().asDiagonal();
        to.core_step = step_of(core.cwiseAbs().maxCoeff(), kCoreSteps);
        const auto r = static_cast<std::size_t>(to.rank);
        to.core.resize(r * r);
        for (Eigen::Index p = 0; p < to.rank; ++p)
            for (Eigen::Index q = 0; q < to.rank; ++q)
                to.core[static_cast<std::size_t>(p) * r + static_cast<std::size_t>(q)] =
                    in_steps<std::int8_t>(core(p, q), to.core_step);
        const auto kept = [&](Eigen::Index p, Eigen::Index q) {
            return to.core[static_cast<std::size_t>(p) * r + static_cast<std::size_t>(q)] * to.core_step *
                   one.column_size[p] * two.column_size[q];
        };
        Tile e = whitened;
        std::fill_n(to.error.begin(), kMostRank + 1, HUGE_VALF);
        to.error[0] = worst(e, limit);
        for (Eigen::Index p = 0; p < to.rank; ++p) {
            VectorXd row = VectorXd::Zero(e.cols()), column = VectorXd::Zero(e.rows());
            for (Eigen::Index q = 0; q <= p; ++q) row += kept(p, q) * two.whitened.col(q);
            for (Eigen::Index q = 0; q < p; ++q) column += kept(q, p) * one.whitened.col(q);
            e.noalias() -= one.whitened.col(p) * row.transpose();
            e.noalias() -= column * two.whitened.col(p).transpose();
            to.error[static_cast<std::size_t>(p) + 1] = worst(e, limit);
        }
    }

    const PlaceMatrix& a_;
    Progress& progress_;
    std::vector<Cluster> cluster_;
    std::vector<Own> own_;
};

/// What a form takes, the pair's second cluster being whole: its core.
std::size_t form_bytes(std::size_t form, std::size_t rows) {
    if (form <= kMostRank) return form * form;
    return (form == kFine ? 18 : 9) * kClusterPlaces * rows;
}

/// The forms' errors of each pair of clusters, and how many places the first has.
struct Choice {
    std::vector<std::array<float, kForms>> error;
    std::vector<std::size_t> rows;
    std::size_t places = 0, most_rank = kMostRank;

    /// The smallest form that is not more than `most` off, or the most precise one.
    std::size_t of(std::size_t pair, double most) const {
        std::size_t best = kFine;
        for (std::size_t form = 0; form < kForms; ++form)
            if ((form <= most_rank || form > kMostRank) && error[pair][form] <= most &&
                form_bytes(form, rows[pair]) < form_bytes(best, rows[pair]))
                best = form;
        return best;
    }
    std::size_t rank(double most) const {
        std::size_t rank = 0;
        for (std::size_t pair = 0; pair < error.size(); ++pair)
            if (const std::size_t form = of(pair, most); form <= kMostRank) rank = std::max(rank, form);
        return rank;
    }
    /// Bytes of all tables.
    std::size_t bytes(double most) const {
        std::size_t sum =
            (kScaleBytes + kVectorBytes * most_rank) * places + kCoreBytes * error.size() + kClusterBegin_bytes;
        for (std::size_t pair = 0; pair < error.size(); ++pair) sum += form_bytes(of(pair, most), rows[pair]);
        return sum;
    }
};

/// The least bound that fits.
double bound_that_fits(const Choice& choice, std::size_t bytes, double most) {
    double low = std::log(1e-7), high = std::log(most);
    for (int i = 0; i < 30; ++i) {
        const double middle = 0.5 * (low + high);
        (choice.bytes(std::exp(middle)) <= bytes ? high : low) = middle;
    }
    return std::exp(high);
}

void add_basis(const std::vector<Cluster>& clusters, PairClusters& to) {
    for (const Cluster& cluster : clusters)
        for (std::size_t i = 0; i < cluster.place.size(); ++i) {
            to.scale.push_back(static_cast<float>(cluster.own[i].scale));
            for (std::size_t r = 0; r < to.rank; ++r) {
                auto& vector = to.basis.emplace_back();
                const auto column = static_cast<Eigen::Index>(r);
                for (Eigen::Index a = 0; a < 3 && column < cluster.basis.cols(); ++a)
                    vector[static_cast<std::size_t>(a)] = static_cast<std::int16_t>(
                        std::lround(kBasisStep * cluster.column_size[column] *
                                    cluster.basis(3 * static_cast<Eigen::Index>(i) + a, column)));
            }
        }
}

void add_core(const Forms& forms, std::size_t form, PairClusters& to) {
    if (form > kMostRank) {
        const bool is_fine = form == kFine;
        to.form.push_back(is_fine ? kFineForm : kDenseForm);
        to.step.push_back(static_cast<float>(is_fine ? forms.fine_step : forms.dense_step));
        if (is_fine)
            to.fine.insert(to.fine.end(), forms.fine.begin(), forms.fine.end());
        else
            to.core.insert(to.core.end(), forms.dense.begin(), forms.dense.end());
        return;
    }
    to.form.push_back(static_cast<std::uint8_t>(form));
    to.step.push_back(static_cast<float>(forms.core_step / (kBasisStep * kBasisStep)));
    for (std::size_t p = 0; p < form; ++p)
        for (std::size_t q = 0; q < form; ++q)
            to.core.push_back(forms.core[p * static_cast<std::size_t>(forms.rank) + q]);
}

}  // namespace

PairClusters cluster_pairs(const PlaceMatrix& a, std::size_t most_bytes, double most_bound,
                           std::vector<std::size_t>& order, std::size_t& least_bytes, Progress& progress) {
    Clusters clusters(a, order, progress);
    Choice choice;
    clusters.each(0.2, 0.6, [&](std::size_t i, std::size_t, const Forms& forms) {
        choice.error.push_back(forms.error);
        choice.rows.push_back(clusters.all()[i].place.size());
    });
    choice.places = order.size();
    least_bytes = choice.bytes(most_bound);
    PairClusters to;
    if (least_bytes > most_bytes) return to;
    double bound = bound_that_fits(choice, most_bytes, most_bound);
    choice.most_rank = choice.rank(bound);  // vectors that no core asks for are bytes for cores
    bound = bound_that_fits(choice, most_bytes, most_bound);
    to.rank = choice.rank(bound);
    add_basis(clusters.all(), to);
    std::size_t pair = 0;
    clusters.each(0.6, 1.0,
                  [&](std::size_t, std::size_t, const Forms& forms) { add_core(forms, choice.of(pair++, bound), to); });
    to.begin = core_begins(to.form, to.places()).begin;
    return to;
}

Matrix3d cluster_block(const PairClusters& clusters, std::size_t i, std::size_t j) {
    const std::size_t one = i / kClusterPlaces, two = j / kClusterPlaces;
    if (one < two) return cluster_block(clusters, j, i).transpose();
    const std::size_t pair = one * (one + 1) / 2 + two, form = clusters.form[pair];
    const std::size_t begin = clusters.begin[pair], block = kClusterPlaces * (i % kClusterPlaces) + j % kClusterPlaces;
    Matrix3d sum = Matrix3d::Zero();
    if (form >= kDenseForm) {
        for (std::size_t c = 0; c < 9; ++c)
            sum(static_cast<Eigen::Index>(c / 3), static_cast<Eigen::Index>(c % 3)) =
                form == kFineForm ? clusters.fine[begin + block][c] : clusters.core[begin + 9 * block + c];
    } else {
        const auto vector = [&](std::size_t place, std::size_t r) {
            const auto& u = clusters.basis[place * clusters.rank + r];
            return Vector3d(u[0], u[1], u[2]);
        };
        for (std::size_t p = 0; p < form; ++p) {
            Vector3d along = Vector3d::Zero();
            for (std::size_t q = 0; q < form; ++q) along += clusters.core[begin + p * form + q] * vector(j, q);
            sum += vector(i, p) * along.transpose();
        }
    }
    return static_cast<double>(clusters.scale[i]) * static_cast<double>(clusters.scale[j]) *
           static_cast<double>(clusters.step[pair]) * sum;
}

}  // namespace haptable
