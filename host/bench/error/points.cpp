// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/error/points.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "codegen/codegen.hpp"
#include "host/base/error.hpp"
#include "host/base/process_cost.hpp"
#include "host/bench/contact/bodies.hpp"
#include "host/bench/subject.hpp"
#include "host/precompute/precompute.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

constexpr double kDepth = 0.001;  // m, of a press

constexpr std::array kElements{Element::kLinear, Element::kAverageNodalPressure, Element::kQuadratic};

constexpr std::array kStorages{Storage::kFloat32, Storage::kFloat16, Storage::kInt16};

/// What the servo gives at a place, N: into contact from outside, then until a god-object that moves has come to rest.
Vector3d force_at(BenchFinger& finger, const Place& place) {
    finger.begin();
    finger.to(place.on_m + kDepth * place.outward);
    Vector3d force = Vector3d::Zero();
    for (int tick = 0; tick < 50; ++tick) force = finger.to(place.on_m - kDepth * place.outward);
    if (!finger.touches()) throw Error("the bench's finger lost contact: nothing was measured");
    return force;
}

void measure_error(const haptable_model& model, const std::vector<Truth>& truths, Point& point) {
    BenchFinger finger(model);
    for (const Truth& truth : truths) {
        const Vector3d force = force_at(finger, truth.place), &n = truth.place.outward;
        const Vector3d body = force_of_body(truth, point.god_object == word(GodObject::kLeastEnergy), kDepth);
        point.error += std::pow(error_of_force(force, body), 2) / static_cast<double>(truths.size());
        point.mean += (n.dot(force) / n.dot(body) - 1.0) / static_cast<double>(truths.size());
    }
    point.error = std::sqrt(point.error);
}

/// A second of sliding, over and over.
double time_of_tick(const Subject& subject, const haptable_model& model) {
    constexpr std::size_t kTicks = 1000, kRounds = 5;
    constexpr int kRepetitions = 7;
    const FingerPath path = subject.circle(kDepth, kTicks);
    haptable_servo servo = subject.touched(path);
    haptable_output out{};
    std::vector<double> sample;
    for (int repetition = 0; repetition < kRepetitions; ++repetition) {
        const double begin = process_cost().cpu_s;
        for (std::size_t i = 0; i < kRounds * kTicks; ++i)
            haptable_servo_step(&model, &servo, path[i % kTicks].data(), 0, &out);
        sample.push_back((process_cost().cpu_s - begin) / static_cast<double>(kRounds * kTicks));
    }
    return median(sample);
}

/// Points have no stiffness of their own on fine meshes. Middles make a mesh as fine as one of twice its nodes a side.
bool is_measured(const Meshed& meshed, Element element, ForceLaw force, bool quick) {
    const Fineness most = force == ForceLaw::kPressureMask && !quick ? Fineness::kFine : Fineness::kMiddle;
    const int finer = element == Element::kQuadratic ? 1 : 0;
    return static_cast<int>(meshed.fineness) + finer <= static_cast<int>(most);
}

/// The tables of a force, and CPU seconds to make them.
fs::path make_tables(Scene scene, Element element, ForceLaw force, double mask_radius_m, const fs::path& build,
                     double& cpu_s) {
    scene.mesh.element = element;
    scene.contact.force = force;
    scene.contact.mask_radius_m = force == ForceLaw::kPressureMask ? mask_radius_m : 0.0;
    fs::path folder = build / fmt::format("{}-{}-{}", scene.name, word(element), word(force));
    Progress progress(true);
    PrecomputeOptions options;
    options.force = true;
    const double begin = process_cost().cpu_s;
    precompute(scene, folder, progress, options);
    cpu_s = process_cost().cpu_s - begin;
    return folder;
}

/// "2.6 %", "107 %"
std::string percent(double share) {
    const double percent = 100.0 * share;
    return std::abs(percent) < 10.0 ? fmt::format("{:.2g} %", percent) : fmt::format("{:.0f} %", percent);
}
Number magnitude(double share) { return number(share, percent(share)); }
Number signed_share(double share) { return number(share, (share < 0.0 ? "" : "+") + percent(share)); }
Cell bytes(double n) {
    return n < 1e6 ? number(n, fmt::format("{:.3g} kB", 1e-3 * n)) : number(n, fmt::format("{:.3g} MB", 1e-6 * n));
}

std::vector<Cell> row_of(const Point& p) {
    return {p.body,
            p.mesh,
            p.element,
            p.force,
            p.god_object,
            p.precision,
            magnitude(p.error),
            signed_share(p.mean),
            seconds(p.tick_s),
            bytes(p.flash_bytes),
            seconds(p.precompute_s)};
}

const std::vector<std::string> kColumns{"body",       "mesh",       "element", "force", "god-object", "precision",
                                        "error, RMS", "mean error", "tick",    "flash", "precompute"};

}  // namespace

double median(std::vector<double> samples) {
    const auto middle = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
    std::nth_element(samples.begin(), middle, samples.end());
    return *middle;
}

Vector3d force_of_body(const Truth& truth, bool slides, double depth_m) {
    const Vector3d& n = truth.place.outward;
    if (slides) return depth_m / n.dot(truth.stiffness_n_per_m.inverse() * n) * n;
    return depth_m * truth.stiffness_n_per_m * n;
}

double error_of_force(const Vector3d& force_n, const Vector3d& body_n) {
    return (force_n - body_n).norm() / body_n.norm();
}

std::vector<Point> measure_points(const Specimen& specimen, const Meshed& meshed, const std::vector<Truth>& truths,
                                  const fs::path& build, bool quick, Progress& progress) {
    std::vector<Point> points;
    double begun = 0.0;
    for (const Element element : kElements)
        for (const ForceLaw force : every<ForceLaw>()) {
            progress.done(begun++ / static_cast<double>(3 * kElements.size()), word(force));
            if (!is_measured(meshed, element, force, quick)) continue;
            double cpu_s = 0.0;
            const fs::path folder = make_tables(meshed.scene, element, force, specimen.finger_radius_m, build, cpu_s);
            for (const Storage storage : kStorages)
                for (const GodObject god_object : every<GodObject>()) {
                    Tables tables = read_tables(folder);
                    tables.precision = storage;
                    tables.god_object = god_object;
                    tables.release_n_per_ms = god_object == GodObject::kLeastEnergy ? 0.01 : 0.0;  // scenes' default
                    const Subject subject(folder, std::move(tables));
                    Point point{specimen.name, meshed.name,      word(element),
                                word(force),   word(god_object), word(storage)};
                    measure_error(bare(subject.model()), truths, point);
                    point.tick_s = time_of_tick(subject, subject.model());
                    point.flash_bytes = static_cast<double>(subject.table_bytes());
                    point.precompute_s = cpu_s;
                    points.push_back(point);
                }
        }
    return points;
}

NumberTable point_table(const std::vector<Point>& points) {
    NumberTable table{kColumns, {}};
    for (const Point& point : points) table.rows.push_back(row_of(point));
    return table;
}

}  // namespace haptable
