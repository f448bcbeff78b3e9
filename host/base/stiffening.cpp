// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/stiffening.hpp"

#include <algorithm>
#include <cmath>

namespace haptable {

namespace {

constexpr double kJustBelow = 0.999999;  // e_0, where the tangent still bends

}  // namespace

double Stiffening::w(double x) const {
    return fung > 0.0 ? std::expm1(fung * x) / fung : x * (1.0 + x * (y2 + x * y3));
}

double Stiffening::slope(double x) const {
    return fung > 0.0 ? std::exp(fung * x) : 1.0 + x * (2.0 * y2 + 3.0 * y3 * x);
}

double StiffeningCurve::factor(double e_j) const {
    if (!(energy_j > 0.0)) return 1.0;
    const double s = std::sqrt(std::clamp(e_j / energy_j, 0.0, 1.0));
    return 1.0 + s * (c[0] + s * (c[1] + s * c[2]));
}

double StiffeningCurve::tangent(double e_j) const {
    if (!(energy_j > 0.0) || e_j >= energy_j) return factor(e_j);
    const double s = std::sqrt(std::max(0.0, e_j / energy_j));
    return 1.0 + s * (2.0 * c[0] + s * (3.0 * c[1] + s * 4.0 * c[2]));
}

double StiffeningCurve::least_tangent() const {
    constexpr int kSteps = 64;
    double least = factor(energy_j);
    for (int k = 0; k <= kSteps; ++k) {
        const double s = static_cast<double>(k) / kSteps;
        const double e_j = kJustBelow * s * s * energy_j;
        least = std::min({least, factor(e_j), tangent(e_j)});
    }
    return least;
}

bool StiffeningCurve::grows() const { return energy_j > 0.0 && std::isfinite(energy_j) && least_tangent() > 0.0; }

double StiffeningCurve::stored(double e_j) const {
    if (!(energy_j > 0.0)) return e_j;
    const double within_j = std::min(e_j, energy_j), s = std::sqrt(std::max(0.0, within_j / energy_j));
    return within_j * (1.0 + s * (2.0 / 3.0 * c[0] + s * (c[1] / 2.0 + s * 0.4 * c[2]))) +
           factor(e_j) * (e_j - within_j);
}

double StiffeningCurve::largest_tangent(double e_j) const {
    constexpr int kSteps = 256;
    double largest = tangent(e_j);
    for (int k = 0; k < kSteps; ++k) {
        const double s = static_cast<double>(k) / kSteps;
        if (s * s * energy_j <= e_j) largest = std::max(largest, tangent(s * s * energy_j));
    }
    return largest;
}

// F = Psi' k d,   e = k d^2 / 2
double StiffeningCurve::energy_at(double force_n, double k_n_per_m) const {
    const auto force = [&](double e_j) { return factor(e_j) * std::sqrt(2.0 * e_j * k_n_per_m); };
    const double linear_j = 0.5 * force_n * force_n / k_n_per_m;
    if (!(energy_j > 0.0)) return linear_j;
    if (force(energy_j) <= force_n) return linear_j / (factor(energy_j) * factor(energy_j));
    double below_j = 0.0, above_j = energy_j;
    for (int k = 0; k < 60; ++k) {
        const double middle_j = 0.5 * (below_j + above_j);
        (force(middle_j) < force_n ? below_j : above_j) = middle_j;
    }
    return above_j;
}

}  // namespace haptable
