// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/error/liver.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <functional>

#include "codegen/in_memory.hpp"
#include "firmware/haptable_scene.h"
#include "host/base/error.hpp"
#include "host/precompute/precompute.hpp"
#include "host/scene/scene.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

constexpr double kStep_m = 2e-5;  // a tick at 20 mm/s
constexpr double kDepth_m = 0.005;
constexpr int kHoldTicks = 100;

/// The scene as far as this part, the parts before it being there.
struct Part {
    const char* name;
    std::function<void(Scene& scene, const Scene& whole)> add;
};

std::vector<Part> parts() {
    return {{"held at its back alone",
             [](Scene& scene, const Scene& /*whole*/) {
                 scene.membranes.clear();
                 scene.beds.clear();
                 scene.gravity.reset();
                 scene.relaxation.clear();
                 scene.fixed = read_scene("meshes/liver.toml").fixed;
             }},
            {"and in its capsule", [](Scene& scene, const Scene& whole) { scene.membranes = whole.membranes; }},
            {"on its beds, below and at the back, and not held",
             [](Scene& scene, const Scene& whole) {
                 scene.fixed.clear();
                 scene.beds = whole.beds;
             }},
            {"sagging, and so another shape",
             [](Scene& scene, const Scene& whole) {
                 scene.gravity = whole.gravity;
                 scene.gravity->prestress = false;
             }},
            {"with the stress of its weight", [](Scene& scene, const Scene& whole) { scene.gravity = whole.gravity; }},
            {"relaxing", [](Scene& scene, const Scene& whole) { scene.relaxation = whole.relaxation; }}};
}

/// A finger over the middle of the touchable surface's box that goes straight down.
class Press {
public:
    explicit Press(const haptable_model& model, const Eigen::AlignedBox3d& box) : model_(model) {
        haptable_servo_init(&servo_);
        finger_m_ = {box.center().x(), box.center().y(), box.max().z() + 0.001};
    }
    /// At the end, N. Throws Error where the body is not met.
    double force_n(double lowest_m) {
        while (haptable_touches(out_.state) == 0 && finger_m_.z() > lowest_m) down_to(lowest_m);
        if (haptable_touches(out_.state) == 0) throw Error("liver: the bench's finger met no surface");
        const double deepest_m = static_cast<double>(out_.god_object_m[2]) - kDepth_m;
        while (finger_m_.z() > deepest_m) down_to(deepest_m);
        for (int tick = 0; tick < kHoldTicks; ++tick) step();
        return Vector3d(out_.force_n[0], out_.force_n[1], out_.force_n[2]).norm();
    }

private:
    void down_to(double lowest_m) {
        finger_m_.z() = std::max(lowest_m, finger_m_.z() - kStep_m);
        step();
    }
    void step() {
        float x[3];
        for (int c = 0; c < 3; ++c) x[c] = static_cast<float>(finger_m_[c]);
        haptable_servo_step(&model_, &servo_, x, now_us_ += HAPTABLE_TICK_US, &out_);
    }
    haptable_model model_;
    haptable_room room_{};
    haptable_servo& servo_ = room_.fingers.servo[0];
    haptable_output out_{};
    Vector3d finger_m_;
    std::uint32_t now_us_ = 0;
};

std::vector<Cell> row_of(const char* name, const Scene& scene, const fs::path& folder) {
    Progress quiet(true);
    PrecomputeOptions options;
    options.force = true;
    const Result result = precompute(scene, folder, quiet, options);
    std::size_t bytes = 0;
    for (const TableBytes& table : result.summary.size.flash) bytes += table.bytes;
    Tables tables = read_tables(folder);
    tables.limits = {};  // the body's own force
    const ServoModel servo = build_model(tables);
    Eigen::AlignedBox3d box;
    for (const auto& x : servo.vertex_m) box.extend(Eigen::Vector3f(x.data()).cast<double>());
    const double force_n = Press(model_in_memory(tables, servo), box).force_n(box.min().z());
    return {name, number(force_n, fmt::format("{:.3f} N", force_n)), count(bytes)};
}

}  // namespace

NumberTable liver_parts(const fs::path& build, Progress& progress) {
    Scene whole = read_scene("meshes/liver-capsule.toml");
    whole.tables.columns = ColumnRows::kNone;
    Scene scene = whole;
    NumberTable table{{"the liver", "force", "tables, bytes"}, {}};
    for (const Part& part : parts()) {
        progress.stage(fmt::format("liver: {}", part.name));
        part.add(scene, whole);
        table.rows.push_back(row_of(part.name, scene, build));
    }
    return table;
}

}  // namespace haptable
