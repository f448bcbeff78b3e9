// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/error/large_strain.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>

#include "host/bench/error/calculix.hpp"
#include "host/bench/error/footprint.hpp"
#include "host/bench/error/points.hpp"
#include "host/bench/error/specimen.hpp"
#include "host/inverse/factor.hpp"
#include "host/precompute/assembly.hpp"
#include "host/precompute/body.hpp"
#include "host/precompute/small_strain.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

constexpr int kLevels = 10;

/// A body with a finger on it.
struct Probed {
    const Specimen& specimen;
    const Scene& scene;
    Place place;
    double step_m;  ///< between the levels
};

struct Felt {
    double displacement_m, ratio;  ///< of the force to the linear one
};

/// Forces, `n_per_m` a metre, that the linear body answers with a step along the way, two steps, ...; what the other
/// one gives under them, along the force: that is what does work. Where the body gives way aside too, the two
/// directions are not one.
std::vector<Felt> pull(const Body& body, const Probed& probed, const LoadShares& shares, const Vector3d& way,
                       const Vector3d& n_per_m, const fs::path& folder) {
    std::vector<NodalForces> loads(kLevels);
    for (int level = 0; level < kLevels; ++level)
        for (const auto& [node, w] : shares)
            loads[static_cast<std::size_t>(level)][node] = w * probed.step_m * (level + 1) * n_per_m;
    const Deck deck{body.mesh.position_m, lists_of(body.mesh.tet), held_of(body.unknown), probed.scene.material, true};
    std::vector<Felt> felt;
    for (const Displacements& moved : run_calculix(deck, loads, folder)) {
        double u = 0.0;
        for (const auto& [node, w] : shares) u += w * moved[static_cast<std::size_t>(node)].dot(n_per_m);
        u /= way.dot(n_per_m);
        felt.push_back({u, probed.step_m * static_cast<double>(felt.size() + 1) / u});
    }
    return felt;
}

/// Where |ratio - 1| first comes to `off`, between the levels; infinite: not within them.
double where_off(const std::vector<Felt>& felt, double off) {
    Felt last{0.0, 1.0};
    for (const Felt& one : felt) {
        const double before = std::abs(last.ratio - 1.0), now = std::abs(one.ratio - 1.0);
        if (now >= off)
            return last.displacement_m + (off - before) / (now - before) * (one.displacement_m - last.displacement_m);
        last = one;
    }
    return INFINITY;
}

Cell depth(double u_m, double furthest_m) {
    if (std::isinf(u_m) || u_m > furthest_m) return fmt::format("over {:.1f} mm", 1e3 * furthest_m);
    return number(u_m, fmt::format("{:.1f} mm", 1e3 * u_m));
}

void touch(const Probed& probed, const fs::path& build, Progress& progress, LargeStrain& result) {
    const Body body = make_body(probed.scene, make_mesh(probed.scene.mesh));
    const Place& place = probed.place;
    const LoadShares shares = shares_on(body.mesh.position_m, body.surface.patch,
                                        {place.on_m, probed.specimen.finger_radius_m, smooth_profile});
    const Factor factor(assemble_free(probed.scene, body));
    const Eigen::Matrix3d s = compliances(factor, std::span(&shares, 1), body.unknown).front().inverse();
    FingerLoad finger{{}, place.outward};
    for (const auto& [node, share] : shares) {
        finger.load.node.push_back(node);
        finger.load.weight.push_back(share);
    }
    const std::vector<Lame> material = materials_of(probed.scene, body);
    const NeoHooke neo_hooke({Element::kLinear, body.mesh.position_m, body.mesh.tet, material});
    const auto [pressing, pulling, sideways] = departures(neo_hooke, factor, body.unknown, std::span(&finger, 1));
    struct Course {
        const char* name;
        Vector3d way;
        Departure expected;
    };
    const std::array courses{Course{"pressing", -place.outward, pressing[0]},
                             Course{"pulling", place.outward, pulling[0]},
                             Course{"sideways", place.outward.unitOrthogonal(), sideways[0]}};
    for (const auto& [name, way, expected] : courses) {
        progress.stage(fmt::format("large strain: {}, {}", probed.specimen.name, name));
        const auto felt =
            pull(body, probed, shares, way, s * way, build / fmt::format("{}-{}", probed.scene.name, name));
        auto& row = result.limits.rows.emplace_back(std::vector<Cell>{probed.specimen.name, name});
        for (double off : {0.05, 0.1, 0.2}) {
            row.push_back(depth(where_off(felt, off), felt.back().displacement_m));
            row.push_back(depth(expected.depth_m(off), felt.back().displacement_m));
        }
        for (const Felt& one : felt) {
            const double u = one.displacement_m;
            const double foreseen = 1.0 + u * (expected.a_per_m + u * expected.b_per_m2);
            result.curve.rows.push_back({probed.specimen.name, name, number(u, fmt::format("{:.2f} mm", 1e3 * u)),
                                         number(one.ratio, fmt::format("{:.3f}", one.ratio)),
                                         number(foreseen, fmt::format("{:.3f}", foreseen))});
        }
    }
}

}  // namespace

LargeStrain large_strain(const fs::path& build, Progress& progress) {
    LargeStrain result{{{"body", "way", "5 % off", "expected", "10 % off", "expected", "20 % off", "expected"}, {}},
                       {{"body", "way", "displacement", "force over the linear one", "expected"}, {}}};
    for (const Specimen& specimen : specimens(true, build)) {
        const double step_m = 0.2 * specimen.finger_radius_m;
        touch({specimen, specimen.meshes.back().scene, places_of(specimen).front(), step_m}, build, progress, result);
    }
    return result;
}

}  // namespace haptable
