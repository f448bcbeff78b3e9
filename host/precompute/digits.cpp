// SPDX-License-Identifier: GPL-2.0-or-later
// |dS| / |S| <= cond(L_ii) |dL_ii| / |L_ii|,   |dL_ij| <= c u cond(D^-1/2 K D^-1/2) sqrt(L_ii L_jj)
#include "host/precompute/digits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace haptable {

namespace {

constexpr double kRounding = 0x1p-53;  // of double

double digits(double relative) { return std::max(0.0, -std::log10(relative)); }

}  // namespace

Digits digits_of(const Summary& summary) {
    const Checks& checks = summary.inverse.checks;
    Digits all{kRounding * checks.scaled_condition * checks.largest_block_condition, summary.size.servo};
    if (summary.inverse.blocks.precision == Precision::kFloat)
        all.inverse = std::max(all.inverse, summary.identity.tolerance);
    return all;
}

std::string describe(const Digits& all, const Summary& summary) {
    const Checks& checks = summary.inverse.checks;
    const double of_k = std::log10(checks.scaled_condition), of_l = std::log10(checks.largest_block_condition);
    return fmt::format(
        "\n  digits of the force: of double's {:.1f}, the condition of K costs {:.1f} and that of L_ii {:.1f}: {:.1f} "
        "are left{}\n  of these the servo's float32 keeps {:.1f} (an error of {:.2g})\n",
        digits(kRounding), of_k, of_l, digits(all.inverse),
        summary.inverse.blocks.precision == Precision::kFloat ? " by --tolerance" : "", digits(all.servo.worst),
        all.servo.worst);
}

std::vector<std::string> digit_warnings(const Scene& scene, const Summary& summary) {
    const Digits all = digits_of(summary);
    const std::string file = scene.file.string();
    std::vector<std::string> warnings;
    if (all.inverse > kMostServoError && summary.inverse.blocks.precision == Precision::kDouble)
        warnings.push_back(fmt::format(
            "{}: K is so badly conditioned ({:.2g}, its blocks {:.2g}) that the force may be off by {:.2g} of itself: "
            "mend slivers in the mesh, fix more of the body, or lower a Poisson's ratio near 0.5",
            file, summary.inverse.checks.scaled_condition, summary.inverse.checks.largest_block_condition,
            all.inverse));
    if (!(all.servo.worst > kMostServoError)) return warnings;
    const bool by_positions = all.servo.force_alone <= 0.5 * all.servo.worst;
    warnings.push_back(fmt::format(
        "{}: the servo's float32 loses {:.2g} of the force in a dent of {:.2g} m: {}{}", file, all.servo.worst,
        all.servo.depth_m,
        by_positions
            ? "its positions are rounded, and the body is far from the origin or much stiffer one way than another"
            : fmt::format("its blocks are much stiffer one way than another (condition {:.2g})",
                          summary.inverse.checks.largest_block_condition),
        summary.size.remedies.empty()
            ? "; no option of the scene was found to leave less: it is the body that is thin there"
            : describe(summary.size.remedies)));
    return warnings;
}

}  // namespace haptable
