// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/compliance/modes.hpp"

#include <fmt/format.h>

#include <numbers>

#include "host/base/error.hpp"
#include "host/base/limits.hpp"
#include "host/base/mass_range.hpp"

namespace haptable {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

double hz_of(double omega_rad_per_s) { return omega_rad_per_s / (2.0 * std::numbers::pi); }

/// The mode at one place: w^T phi_k.
Vector3d shape_at(const Body& body, const PairControls& controls, const NodeWeights& place, const NaturalModes& modes,
                  Index k) {
    Vector3d shape = Vector3d::Zero();
    for (std::size_t i = 0; i < place.node.size(); ++i) {
        const std::int32_t node = controls.node[static_cast<std::size_t>(place.node[i])];
        const Index at = Index{3} * body.unknown[static_cast<std::size_t>(node)];
        shape += place.weight[i] * modes.shape.col(k).segment<3>(at);
    }
    return shape;
}

}  // namespace

void require_rendered(const Scene& scene, const NaturalModes& modes) {
    constexpr double kNyquist_hz = 0.5 / kServoTick_s;
    if (const double slowest_hz = hz_of(modes.omega_rad_per_s[0]); !(slowest_hz >= kLeastMode_hz))
        throw Error(
            fmt::format("{}:{}: body.modes: mode 1 swings with {:.3g} Hz, and a servo's modes with {:g} Hz at "
                        "least: give mass in kg, densities in kg/m^3, young in Pa and the mesh in m",
                        scene.file.string(), scene.body_modes->line, slowest_hz, kLeastMode_hz));
    Index slow = 0;
    while (slow < modes.omega_rad_per_s.size() && hz_of(modes.omega_rad_per_s[slow]) < kNyquist_hz) ++slow;
    if (slow == modes.omega_rad_per_s.size()) return;
    throw Error(fmt::format(
        "{}:{}: body.modes: mode {} swings with {:.3g} Hz, and ticks of a millisecond show less "
        "than {:g} Hz: {}",
        scene.file.string(), scene.body_modes->line, slow + 1, hz_of(modes.omega_rad_per_s[slow]), kNyquist_hz,
        slow == 0 ? "this body is too stiff to ring here; remove modes" : fmt::format("write modes = {}", slow)));
}

ModeTables mode_tables(const Scene& scene, const Body& body, const NaturalModes& modes, const PairControls& controls,
                       std::span<const std::int32_t> row) {
    ModeTables tables;
    tables.omega_rad_per_s.assign(modes.omega_rad_per_s.begin(), modes.omega_rad_per_s.end());
    tables.damping_ratio = scene.body_modes->damping_ratio;
    tables.control_count = controls.weights.size();
    for (const NodeWeights& place : controls.weights)
        for (Index k = 0; k < modes.shape.cols(); ++k) {
            const Vector3d shape = shape_at(body, controls, place, modes, k);
            tables.shape.push_back({shape[0], shape[1], shape[2]});
        }
    for (const std::int32_t node : row)
        for (Index k = 0; k < modes.shape.cols(); ++k) {
            const Eigen::Vector3f shape = modes.shape.col(k).segment<3>(Index{3} * node).cast<float>();
            tables.row.push_back({shape[0], shape[1], shape[2]});
        }
    return tables;
}

ModeFacts mode_facts(const Scene& scene, const RestInverse& rest, std::span<const std::int32_t> node,
                     std::span<const Eigen::Matrix3d> l_ii) {
    ModeFacts facts;
    facts.damping_ratio = scene.body_modes->damping_ratio;
    for (const double omega : rest.modes().omega_rad_per_s) facts.frequency_hz.push_back(hz_of(omega));
    double carried = 0.0, left = 0.0;
    for (std::size_t i = 0; i < node.size(); ++i) {
        carried -= rest.correction(node[i], node[i]).trace();
        left += l_ii[i].trace();
    }
    facts.share = carried / (carried + left);
    return facts;
}

std::string describe(const ModeFacts& facts) {
    return fmt::format(
        "  rings in {} modes of {:.3g} to {:.3g} Hz, damping ratio {:g}: they carry {:.0f} % of how far "
        "the touchable nodes give way\n",
        facts.frequency_hz.size(), facts.frequency_hz.front(), facts.frequency_hz.back(), facts.damping_ratio,
        100.0 * facts.share);
}

}  // namespace haptable
