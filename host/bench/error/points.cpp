// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/error/points.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <tuple>

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

constexpr const char* kPaper = "the paper, 1998";

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

/// Whether a finer mesh brings the force to the body's. That of a point does not stay: it goes to zero with the mesh,
/// and is right on one mesh by chance.
bool has_a_size(const Point& point) {
    return point.force != word(ForceLaw::kInterpolated) && point.force != word(ForceLaw::kConsistent) &&
           point.force != kPaper;
}

/// Whether no other point is better in both, or as good in one and better in the other.
bool is_best(const Point& point, const std::vector<Point>& points, double Point::*axis) {
    return has_a_size(point) && std::none_of(points.begin(), points.end(), [&](const Point& other) {
               return has_a_size(other) && other.body == point.body && other.error <= point.error &&
                      other.*axis <= point.*axis && (other.error < point.error || other.*axis < point.*axis);
           });
}

/// "2.6 %", "107 %"
std::string percent(double share) {
    const double percent = 100.0 * share;
    return std::abs(percent) < 10.0 ? fmt::format("{:.2g} %", percent) : fmt::format("{:.0f} %", percent);
}
Number magnitude(double share) { return number(share, percent(share)); }
Number signed_share(double share) { return number(share, (share < 0.0 ? "" : "+") + percent(share)); }
/// NaN: the paper does not tell.
Cell bytes(double n) {
    if (std::isnan(n)) return "";
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
            std::isnan(p.precompute_s) ? Cell("") : seconds(p.precompute_s),
            p.best};
}

const std::vector<std::string> kColumns{"body",       "mesh",       "element", "force", "god-object", "precision",
                                        "error, RMS", "mean error", "tick",    "flash", "precompute", "best in"};

/// The force of the paper's Table 2, on its Pentium Pro of 200 MHz. Its equations are those of our point that is
/// interpolated, nearest; so is its error. It had the same counts of nodes and patches, and a mouse of its own.
std::optional<Point> point_of_paper(const std::vector<Point>& ours) {
    for (const Point& point : ours) {
        const bool is_cube = point.body == "cube, nu 0.49" && point.mesh == "5 a side";
        if (!(is_cube || point.mesh == "1,713 nodes") || point.force != word(ForceLaw::kInterpolated)) continue;
        Point paper = point;
        paper.force = kPaper;
        paper.precision = "";
        paper.tick_s = is_cube ? 15e-6 : 12e-6;
        paper.flash_bytes = paper.precompute_s = NAN;
        return paper;
    }
    return {};
}

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
        for (const ForceLaw force : {ForceLaw::kInterpolated, ForceLaw::kConsistent, ForceLaw::kPressureMask}) {
            progress.done(begun++ / static_cast<double>(3 * kElements.size()), word(force));
            if (!is_measured(meshed, element, force, quick)) continue;
            double cpu_s = 0.0;
            const fs::path folder = make_tables(meshed.scene, element, force, specimen.finger_radius_m, build, cpu_s);
            for (const Storage storage : kStorages)
                for (const GodObject god_object : {GodObject::kNearest, GodObject::kLeastEnergy}) {
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
    if (const auto paper = point_of_paper(points)) points.push_back(*paper);
    return points;
}

void mark_best(std::vector<Point>& points) {
    struct Axis {
        const char* name;
        double Point::*value;
    };
    for (Point& point : points) {
        std::vector<std::string> best;
        for (const Axis& axis : {Axis{"time", &Point::tick_s}, Axis{"flash", &Point::flash_bytes},
                                 Axis{"precompute", &Point::precompute_s}})
            if (is_best(point, points, axis.value)) best.emplace_back(axis.name);
        point.best = fmt::format("{}", fmt::join(best, ", "));
    }
}

NumberTable point_table(const std::vector<Point>& points) {
    NumberTable table{kColumns, {}};
    for (const Point& point : points) table.rows.push_back(row_of(point));
    return table;
}

NumberTable front_table(const std::vector<Point>& points) {
    std::vector<Point> best;
    std::copy_if(points.begin(), points.end(), std::back_inserter(best),
                 [](const Point& point) { return point.best.find("time") != std::string::npos; });
    std::stable_sort(best.begin(), best.end(), [](const Point& a, const Point& b) {
        return std::tie(a.body, a.error) < std::tie(b.body, b.error);
    });
    return point_table(best);
}

NumberTable order_table(const std::vector<Point>& points) {
    NumberTable table{{"body", "element", "mesh", "mean error of the mask", "order"}, {}};
    std::map<std::pair<std::string, std::string>, const Point*> coarser;
    for (const Point& point : points) {
        if (point.force != word(ForceLaw::kPressureMask) || point.god_object != word(GodObject::kNearest) ||
            point.precision != word(Storage::kFloat32) || point.body.find("cube") != 0)
            continue;
        table.rows.push_back({point.body, point.element, point.mesh, signed_share(point.mean), std::string()});
        const Point*& last = coarser[{point.body, point.element}];
        // Nothing is told by an error that is not above the truth's own, or that crosses zero.
        constexpr double kTold = 0.002;
        if (last != nullptr && last->mean * point.mean > 0.0 && std::abs(point.mean) > kTold) {
            const double finer = (std::stod(point.mesh) - 1.0) / (std::stod(last->mesh) - 1.0);  // "13 a side"
            const double order = std::log(std::abs(last->mean / point.mean)) / std::log(finer);
            table.rows.back().back() = number(order, fmt::format("{:.1f}", order));
        }
        last = &point;
    }
    return table;
}

}  // namespace haptable
