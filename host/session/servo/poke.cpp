// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/session/servo/poke.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>

#include "host/base/command_line.hpp"

namespace haptable {

namespace {

using Eigen::Vector3d;

constexpr double kClearance_m = 0.01, kStep_m = 2e-5;  // in a tick: slow, so that no search is left for the next one
constexpr int kHold_ticks = 100, kRing_ticks = 5000;   // until nothing swings any more
constexpr double kDeepest_m = 10.0;                    // some seconds of work

Vector3d vertex(const haptable_model& model, int v) { return Eigen::Vector3f(model.vertex_m[v]).cast<double>(); }

Eigen::AlignedBox3d box_of(const haptable_model& model) {
    Eigen::AlignedBox3d box;
    for (int v = 0; v < model.vertex_count; ++v) box.extend(vertex(model, v));
    return box;
}

/// The height of a patch over (x, y); -infinity beside it.
double height_over(const haptable_model& model, int patch, const Vector3d& x) {
    const Vector3d a = vertex(model, model.patch[patch][0]);
    Eigen::Matrix2d edges;
    edges.col(0) = (vertex(model, model.patch[patch][1]) - a).head<2>();
    edges.col(1) = (vertex(model, model.patch[patch][2]) - a).head<2>();
    const double twice_area = edges.determinant();
    if (twice_area == 0.0) return -INFINITY;
    const Vector3d b = vertex(model, model.patch[patch][1]), c = vertex(model, model.patch[patch][2]);
    const Eigen::Vector2d d = (x - a).head<2>();
    const double s = (d.x() * edges(1, 1) - d.y() * edges(0, 1)) / twice_area;
    const double t = (edges(0, 0) * d.y() - edges(1, 0) * d.x()) / twice_area;
    return s < 0.0 || t < 0.0 || s + t > 1.0 ? -INFINITY : a.z() + s * (b - a).z() + t * (c - a).z();
}

Vector3d top_of(const haptable_model& model) {
    const Eigen::AlignedBox3d box = box_of(model);
    Vector3d top = box.center();
    top.z() = -INFINITY;
    for (int p = 0; p < model.patch_count; ++p) top.z() = std::max(top.z(), height_over(model, p, top));
    if (std::isfinite(top.z())) return top;
    const Vector3d middle(box.center().x(), box.center().y(), box.max().z());
    top = vertex(model, 0);
    for (int v = 1; v < model.vertex_count; ++v)
        if ((vertex(model, v) - middle).norm() < (top - middle).norm()) top = vertex(model, v);
    return top;
}

}  // namespace

Vector3d place_of(const std::string& text, const haptable_model& model) {
    if (text == "top") return top_of(model);
    Vector3d at_m;
    int used = 0;
    if (std::sscanf(text.c_str(), "%lf,%lf,%lf%n", &at_m[0], &at_m[1], &at_m[2], &used) != 3 ||
        static_cast<std::size_t>(used) != text.size() || !at_m.allFinite())
        throw BadCommandLine("--poke " + text + ": give X,Y,Z in metres, as in 0.015,0.015,0.03, or top");
    return at_m;
}

std::string where_it_is(const haptable_model& model) {
    const Eigen::AlignedBox3d box = box_of(model);
    return fmt::format("the touchable surface lies in ({:.4g} {:.4g} {:.4g}) to ({:.4g} {:.4g} {:.4g}) m",
                       box.min().x(), box.min().y(), box.min().z(), box.max().x(), box.max().y(), box.max().z());
}

Poked poke(const ServoScene& scene, const Poke& poke) {
    const Vector3d in = poke.direction.normalized();
    if (!in.allFinite() || !(in.norm() > 0.5)) throw BadCommandLine("--direction: give a direction that has a length");
    if (!(poke.depth_m <= kDeepest_m))
        throw BadCommandLine(fmt::format("--depth: {:.4g} m: give {} m at the most: {}", poke.depth_m, kDeepest_m,
                                         where_it_is(*scene.model)));
    SceneState state(*scene.model, nullptr, nullptr, scene.modes);  // one finger, on a body that does not give way
    require_whole_tables(scene, state);
    const int hold_ticks = scene.modes != nullptr ? kRing_ticks : kHold_ticks;
    haptable_output out{};
    Vector3d finger_m = poke.at_m;
    const int ways = static_cast<int>(std::ceil((kClearance_m + poke.depth_m) / kStep_m));
    for (int tick = 0; tick <= ways + hold_ticks; ++tick) {
        const double share = std::min(1.0, static_cast<double>(tick) / ways);
        finger_m = poke.at_m + ((kClearance_m + poke.depth_m) * share - kClearance_m) * in;
        const std::array<float, 3> at_m = to_finger(finger_m.data());
        const haptable_input finger{{at_m[0], at_m[1], at_m[2]}, 0, 1};
        state.step(&finger, static_cast<std::uint32_t>(tick) * HAPTABLE_TICK_US, &out);
    }
    if (haptable_touches(out.state) == 0)
        throw Error(fmt::format(
            "the poke from ({:.4g} {:.4g} {:.4g}) to ({:.4g} {:.4g} {:.4g}) m ends without contact: {}",
            (poke.at_m - kClearance_m * in).x(), (poke.at_m - kClearance_m * in).y(),
            (poke.at_m - kClearance_m * in).z(), finger_m.x(), finger_m.y(), finger_m.z(), where_it_is(*scene.model)));
    Poked end{finger_m,
              Eigen::Vector3f(out.god_object_m).cast<double>(),
              Eigen::Vector3f(out.force_n).cast<double>(),
              {},
              0.0};
    for (std::size_t c = 0; c < 3; ++c) end.node[c] = mesh_node(scene, out, c);
    end.depth_m = (end.finger_m - end.god_object_m).norm();
    return end;
}

}  // namespace haptable
