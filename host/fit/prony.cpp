// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/fit/prony.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <unsupported/Eigen/NonLinearOptimization>

#include "host/base/error.hpp"
#include "host/dense/dense.hpp"

namespace haptable {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The depth convolved with exp(-t / time); and with t / time exp(-t / time), its derivative by log(time).
struct Convolved {
    VectorXd value, by_log_time;
};

Convolved convolve(const ForceRecord& record, double time_s) {
    const auto n = static_cast<Eigen::Index>(record.time_s.size());
    Convolved c{VectorXd(n), VectorXd(n)};
    double value = record.depth_m[0], slope = 0.0;
    for (Eigen::Index i = 0; i < n; ++i) {
        const auto s = static_cast<std::size_t>(i);
        if (i > 0) {
            const double ticks = (record.time_s[s] - record.time_s[s - 1]) / time_s, decay = std::exp(-ticks);
            const double rise = -std::expm1(-ticks) / ticks, change = record.depth_m[s] - record.depth_m[s - 1];
            slope = decay * (slope + ticks * value) + change * (rise - decay);
            value = decay * value + rise * change;
        }
        c.value[i] = value;
        c.by_log_time[i] = slope;
    }
    return c;
}

VectorXd as_vector(const std::vector<double>& v) {
    return Eigen::Map<const VectorXd>(v.data(), static_cast<Eigen::Index>(v.size()));
}

/// F - measured by the logarithms of what is left of the stiffness, of each term's part of it, and of each term's time:
/// all of them stay positive.
class Residual {
public:
    explicit Residual(const ForceRecord& record) : record_(record), depth_(as_vector(record.depth_m)) {}

    int operator()(const VectorXd& x, VectorXd& out) const {
        out = std::exp(x[0]) * depth_ - as_vector(record_.force_n);
        for (Eigen::Index k = 0; k < terms(x); ++k) out += std::exp(x[1 + k]) * convolve(record_, time_s(x, k)).value;
        return 0;
    }
    int df(const VectorXd& x, MatrixXd& by_x) const {
        by_x.resize(depth_.size(), x.size());
        by_x.col(0) = std::exp(x[0]) * depth_;
        for (Eigen::Index k = 0; k < terms(x); ++k) {
            const Convolved c = convolve(record_, time_s(x, k));
            by_x.col(1 + k) = std::exp(x[1 + k]) * c.value;
            by_x.col(1 + terms(x) + k) = std::exp(x[1 + k]) * c.by_log_time;
        }
        return 0;
    }
    int values() const { return static_cast<int>(depth_.size()); }
    static Eigen::Index terms(const VectorXd& x) { return (x.size() - 1) / 2; }
    /// Within what a number can be, however far a step goes.
    static double time_s(const VectorXd& x, Eigen::Index k) {
        return std::exp(std::clamp(x[1 + terms(x) + k], -60.0, 60.0));
    }

private:
    const ForceRecord& record_;
    VectorXd depth_;
};

/// The least time between two samples: they may be closer together where much happens.
double closest_s(const ForceRecord& record) {
    double least = record.time_s.back() - record.time_s.front();
    for (std::size_t i = 1; i < record.time_s.size(); ++i)
        least = std::min(least, record.time_s[i] - record.time_s[i - 1]);
    return least;
}

/// Times spread evenly over the decades between a sample and the whole record, and the parts that fit best with them.
VectorXd begin(const ForceRecord& record, std::size_t terms) {
    const double whole_s = record.time_s.back() - record.time_s.front();
    const double sample_s = closest_s(record);
    const auto count = static_cast<Eigen::Index>(terms);
    VectorXd x(1 + 2 * count);
    MatrixXd parts(static_cast<Eigen::Index>(record.time_s.size()), 1 + count);
    parts.col(0) = as_vector(record.depth_m);
    for (Eigen::Index k = 0; k < count; ++k) {
        const double share = (static_cast<double>(k) + 0.5) / static_cast<double>(terms);
        x[1 + count + k] = std::log(2.0 * sample_s) + share * std::log(0.5 * whole_s / (2.0 * sample_s));
        parts.col(1 + k) = convolve(record, Residual::time_s(x, k)).value;
    }
    const VectorXd part = least_squares(parts, as_vector(record.force_n));
    const double least = 0.02 * std::max(part.sum(), 1e-30);
    for (Eigen::Index k = 0; k <= count; ++k) x[k] = std::log(std::max(part[k], least));
    return x;
}

/// By ascending time.
std::vector<Eigen::Index> order_of(const VectorXd& x) {
    std::vector<Eigen::Index> order(static_cast<std::size_t>(Residual::terms(x)));
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(),
              [&](Eigen::Index a, Eigen::Index b) { return Residual::time_s(x, a) < Residual::time_s(x, b); });
    return order;
}

constexpr double kRounding = 1e-7;  // of the largest force: a record has no more digits

/// Standard errors of each logarithm, so of each number as a part of itself.
VectorXd errors_of(const Residual& residual, const VectorXd& x, double misfit_n) {
    MatrixXd by_x;
    residual.df(x, by_x);
    const double freedom = std::max(1.0, static_cast<double>(by_x.rows() - by_x.cols()));
    const double variance = misfit_n * misfit_n * static_cast<double>(by_x.rows()) / freedom;
    const MatrixXd normal = by_x.transpose() * by_x;
    const MatrixXd covariance = variance * normal.ldlt().solve(MatrixXd::Identity(x.size(), x.size()));
    return covariance.diagonal().cwiseAbs().cwiseSqrt();
}

PronyFit fit_of(const ForceRecord& record, const VectorXd& x) {
    const Residual residual(record);
    const Eigen::Index terms = Residual::terms(x);
    VectorXd difference;
    residual(x, difference);
    PronyFit fit;
    fit.stiffness_n_per_m = x.head(1 + terms).array().exp().sum();
    fit.misfit_n = std::sqrt(difference.squaredNorm() / static_cast<double>(difference.size()));
    const double rounding_n = kRounding * *std::max_element(record.force_n.begin(), record.force_n.end());
    const VectorXd error = errors_of(residual, x, std::max(fit.misfit_n, rounding_n));
    fit.stiffness_error =
        x.head(1 + terms).array().exp().matrix().cwiseProduct(error.head(1 + terms)).norm() / fit.stiffness_n_per_m;
    for (const Eigen::Index k : order_of(x)) {
        fit.relaxation.push_back({std::exp(x[1 + k]) / fit.stiffness_n_per_m, Residual::time_s(x, k)});
        fit.share_error.push_back(error[1 + k]);
        fit.time_error.push_back(error[1 + terms + k]);
    }
    fit.force_n = relaxed_force(record, fit.stiffness_n_per_m, fit.relaxation);
    return fit;
}

PronyFit fit_terms(const ForceRecord& record, std::size_t terms) {
    Residual residual(record);
    VectorXd x = begin(record, terms);
    Eigen::LevenbergMarquardt<Residual> solver(residual);
    solver.parameters.maxfev = 400;
    solver.parameters.xtol = solver.parameters.ftol = 1e-12;
    solver.minimize(x);
    if (!x.allFinite()) throw Error(fmt::format("the fit of {} terms found no numbers: give fewer --terms", terms));
    return fit_of(record, x);
}

/// Each number of a term is known to half of itself: not, where two have one time, or where rounding is fitted.
bool is_determined(const PronyFit& fit) {
    constexpr double kMost = 0.5;
    const auto is_known = [](double error) { return error < kMost; };
    return std::all_of(fit.share_error.begin(), fit.share_error.end(), is_known) &&
           std::all_of(fit.time_error.begin(), fit.time_error.end(), is_known);
}

/// Schwarz's: a term is worth its two numbers only where it explains more than noise, or than rounding.
double criterion(const PronyFit& fit) {
    const double least_n = kRounding * *std::max_element(fit.force_n.begin(), fit.force_n.end());
    const auto n = static_cast<double>(fit.force_n.size());
    const auto numbers = static_cast<double>(1 + 2 * fit.relaxation.size());
    return 2.0 * n * std::log(std::max(fit.misfit_n, least_n)) + numbers * std::log(n);
}

}  // namespace

std::vector<double> relaxed_force(const ForceRecord& record, double stiffness_n_per_m,
                                  const std::vector<RelaxationTerm>& relaxation) {
    VectorXd depth_m = rest_share(relaxation) * as_vector(record.depth_m);
    for (const RelaxationTerm& term : relaxation) depth_m += term.share * convolve(record, term.time_s).value;
    const VectorXd force_n = stiffness_n_per_m * depth_m;
    return {force_n.begin(), force_n.end()};
}

PronyFit fit_prony(const ForceRecord& record, std::size_t terms, std::size_t most_terms) {
    if (record.time_s.empty())
        throw Error("the record has no times, and a relaxation is of time: give --stiffening, or a column time_s");
    if (record.time_s.size() < 10 * (1 + terms))
        throw Error(
            fmt::format("{} samples up to where the body lets go are too few for {} terms: give 10 for each "
                        "number that is sought",
                        record.time_s.size(), terms));
    if (terms > 0) {
        PronyFit fit = fit_terms(record, terms);
        return terms == 1 || is_determined(fit) ? fit : fit_prony(record, terms - 1, most_terms);
    }
    PronyFit best = fit_terms(record, 0);
    for (std::size_t n = 1; n <= most_terms && record.time_s.size() >= 10 * (1 + n); ++n) {
        PronyFit fit = fit_terms(record, n);
        if (is_determined(fit) && criterion(fit) < criterion(best)) best = std::move(fit);
    }
    return best;
}

}  // namespace haptable
