// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/press.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "host/dense/dense.hpp"
#include "host/tables/npy.hpp"

namespace haptable {

namespace {

constexpr double kFelt = 3.0;  // times the friction: then it is told apart from it

/// "1.16 mN": three digits and a prefix.
std::string newtons(double n) {
    return n < 1e-3  ? fmt::format("{:.3g} uN", 1e6 * n)
           : n < 1.0 ? fmt::format("{:.3g} mN", 1e3 * n)
                     : fmt::format("{:.3g} N", n);
}

/// Two digits: nobody wants more of a suggestion.
double rounded(double x) {
    const double step = std::pow(10.0, std::floor(std::log10(x)) - 1.0);
    return step * std::ceil(x / step);
}

}  // namespace

PressStiffness press_stiffness(const Scene& scene, const std::filesystem::path& folder) {
    const bool mask = scene.contact.force == ForceLaw::kPressureMask;
    const Array<double> blocks = read_npy<double>(folder / (mask ? "vertex_compliance.npy" : "stiffness.npy"));
    PressStiffness press;
    std::vector<double> mean;
    for (std::size_t i = 0; i + 9 <= blocks.values.size(); i += 9) {
        Eigen::Matrix3d s = Eigen::Map<const Eigen::Matrix3d>(&blocks.values[i]);
        if (mask) s = Eigen::Matrix3d(s.inverse());
        if (!s.allFinite()) continue;  // a mask over held nodes alone
        mean.push_back(s.trace() / 3.0);
        press.largest_n_per_m = std::max(press.largest_n_per_m, symmetric_eigenvalues(0.5 * (s + s.transpose()))[2]);
    }
    if (mean.empty()) return press;
    const auto middle = mean.begin() + static_cast<std::ptrdiff_t>(mean.size() / 2);
    std::nth_element(mean.begin(), middle, mean.end());
    press.typical_n_per_m = *middle;
    return press;
}

std::string describe(const PressStiffness& press, const Scene& scene) {
    if (!(press.typical_n_per_m > 0.0)) return "";
    const double force_n = kPress_m * press.typical_n_per_m;
    const double friction_n = scene.device.friction_n, most_n = scene.device.max_force_n;
    const auto young = [&](double wanted_n) {
        return fmt::format("try young = {:.3g}", rounded(scene.material.young_pa * wanted_n / force_n));
    };
    std::string verdict;
    if (force_n > most_n)
        verdict = fmt::format("more than your device's {}: {}", newtons(most_n), young(0.5 * most_n));
    else if (force_n < kFelt * friction_n)
        verdict = fmt::format("{} your device's {} friction: {}", force_n < friction_n ? "below" : "hardly more than",
                              newtons(friction_n), young(10.0 * friction_n));
    else
        verdict = fmt::format("your device has {} friction and gives {}", newtons(friction_n), newtons(most_n));
    return fmt::format(
        "  5 mm of press cost {} at a typical place ({:.3g} N/m; the stiffest free one {:.3g} N/m); {}\n",
        newtons(force_n), press.typical_n_per_m, press.largest_n_per_m, verdict);
}

}  // namespace haptable
