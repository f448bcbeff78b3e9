// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/strokes/stroke.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "host/link/finger_path.hpp"
#include "host/strokes/law.hpp"
#include "host/strokes/motion.hpp"

namespace haptable {

namespace {

using Eigen::Vector3d;

constexpr double kSlowest_m_s = 0.01, kFastest_m_s = 2.0, kPass_m_s = 5.0;
// Depth and height as parts of the body's size.
constexpr double kShallow = 1e-4, kDeepest = 0.05, kHigh = 0.02;
constexpr std::size_t kMostTicksOfLine = 200;

/// Well mixed bits of two numbers (Steele, Lea and Flood's SplitMix64).
std::uint64_t mix(std::uint64_t a, std::uint64_t b) {
    std::uint64_t z = a * 0x9e3779b97f4a7c15U + b + 0x9e3779b97f4a7c15U;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31);
}

/// Along the normal.
Vector3d twice_area(const ServoModel& servo, std::size_t patch) {
    const Vector3d a = corner_of(servo, patch, 0);
    return (corner_of(servo, patch, 1) - a).cross(corner_of(servo, patch, 2) - a);
}

using Path = std::vector<std::array<float, 3>>;

/// The same way, by so much aside.
Path beside(Path path, const Vector3d& by_m) {
    for (auto& x : path)
        for (std::size_t c = 0; c < 3; ++c) x[c] += static_cast<float>(by_m[static_cast<Eigen::Index>(c)]);
    return path;
}

/// A finger on its way over a surface, and its dice.
struct Pen {
    const ServoModel& servo;
    const std::vector<double>& area;  ///< [p] sums of the areas so far
    double size_m;
    std::mt19937_64 dice;
    Path path = {};
    Vector3d at = Vector3d::Zero();

    double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(dice); }
    double scale(double low, double high) { return std::exp(between(std::log(low), std::log(high))); }
    std::size_t below(std::size_t count) { return std::uniform_int_distribution<std::size_t>(0, count - 1)(dice); }
    double speed() { return scale(kSlowest_m_s, kFastest_m_s); }
    double depth() { return size_m * scale(kShallow, kDeepest); }
    double height() { return size_m * scale(kShallow, kHigh); }
    Vector3d direction() {
        for (;;) {
            const Vector3d d(between(-1, 1), between(-1, 1), between(-1, 1));
            if (d.norm() < 1.0 && d.norm() > 0.1) return d.normalized();
        }
    }
    Vector3d along(const Vector3d& normal) { return direction().cross(normal).normalized(); }

    Vector3d normal(std::size_t patch) const { return twice_area(servo, patch).normalized(); }
    /// Everywhere on the surface as often as on any patch, however small.
    std::size_t any_patch() {
        if (below(2) == 0) return below(area.size());
        const auto found = std::lower_bound(area.begin(), area.end(), between(0.0, area.back()));
        return static_cast<std::size_t>(std::min(found, area.end() - 1) - area.begin());
    }
    /// Inside, or, one in four, on an edge or a vertex.
    Vector3d any_point(std::size_t patch) {
        Vector3d alpha(between(0, 1), between(0, 1), between(0, 1));
        if (below(4) == 0) alpha[static_cast<Eigen::Index>(below(3))] = 0.0;
        if (below(16) == 0) alpha = Vector3d::Unit(static_cast<Eigen::Index>(below(3)));
        alpha /= alpha.sum();
        return point_of(servo, {patch, alpha});
    }
    std::size_t any_neighbour(std::size_t patch) {
        const std::uint16_t next = servo.neighbour[patch][below(3)];
        return next == HAPTABLE_NONE ? patch : next;
    }
    /// Sharpness of the edge opposite to a corner: 0 where it is flat, 2 where it is a knife's.
    double sharpness(std::size_t patch, std::size_t c) const {
        const std::uint16_t across = servo.neighbour[patch][c];
        return across == HAPTABLE_NONE ? 0.0 : 1.0 - normal(patch).dot(normal(across));
    }

    void put(const Vector3d& x) {
        at = x;
        std::copy_n(x.data(), 3, path.emplace_back().begin());
    }
    /// Straight towards `to`, evenly; a slow one does not get there.
    void line(const Vector3d& to, double speed_m_s) {
        const Vector3d from = at;
        const auto ticks = static_cast<std::size_t>(std::ceil((to - from).norm() / (speed_m_s * kTick_s)));
        for (std::size_t i = 1; i <= std::min(ticks, kMostTicksOfLine); ++i)
            put(from + static_cast<double>(i) / static_cast<double>(ticks) * (to - from));
    }
    /// In or out: no slower than that it arrives.
    void reach(const Vector3d& to, double speed_m_s) {
        line(to, std::max(speed_m_s, (to - at).norm() / (kTick_s * kMostTicksOfLine) * 1.01));
    }
    void rest(std::size_t ticks) {
        for (std::size_t i = 0; i < ticks; ++i) put(at);
    }
};

/// In along the normal, straight ways at that depth, out along the normal of the begin.
void slide(Pen& pen) {
    const std::size_t patch = pen.any_patch();
    const Vector3d n = pen.normal(patch), g = pen.any_point(patch);
    const double depth = pen.depth(), high = pen.height();
    pen.put(g + high * n);
    pen.reach(g - depth * n, pen.speed());
    for (std::size_t turn = 1 + pen.below(5); turn > 0; --turn) {
        pen.line(pen.at + pen.size_m * pen.scale(0.01, 0.5) * pen.along(n), pen.speed());
        if (pen.below(4) == 0) pen.rest(1 + pen.below(5));
    }
    pen.reach(pen.at + (depth + 2.0 * high) * n, pen.speed());
}

/// From patch to neighbouring patch, at a depth under each: over edges and into creases.
void follow(Pen& pen) {
    std::size_t patch = pen.any_patch();
    const double depth = pen.depth(), speed = pen.speed();
    pen.put(pen.any_point(patch) + pen.height() * pen.normal(patch));
    for (std::size_t steps = 2 + pen.below(14); steps > 0; --steps) {
        pen.line(pen.any_point(patch) - depth * pen.normal(patch), speed);
        patch = pen.any_neighbour(patch);
    }
    pen.reach(pen.at + (depth + pen.size_m * kHigh) * pen.normal(patch), pen.speed());
}

/// Square to the sharpest of a few edges, to both sides of it.
void cross_edge(Pen& pen) {
    std::size_t patch = pen.any_patch(), c = pen.below(3);
    for (int tries = 0; tries < 8; ++tries) {
        const std::size_t p = pen.any_patch(), k = pen.below(3);
        if (pen.sharpness(p, k) > pen.sharpness(patch, c)) patch = p, c = k;
    }
    const Vector3d a = corner_of(pen.servo, patch, (c + 1) % 3), b = corner_of(pen.servo, patch, (c + 2) % 3);
    const Vector3d n = pen.normal(patch), across = (b - a).cross(n).normalized();
    const Vector3d middle = a + pen.between(0.0, 1.0) * (b - a);
    const double depth = pen.depth(), reach = pen.size_m * pen.scale(0.005, 0.1);
    pen.put(middle - 0.5 * reach * across + 2.0 * depth * n);
    pen.reach(middle - 0.5 * reach * across - depth * n, pen.speed());
    const double speed = pen.speed();
    for (std::size_t turn = 1 + pen.below(4); turn > 0; --turn) {
        pen.line(middle + reach * across - depth * n, speed);
        pen.line(middle - reach * across - depth * n, speed);
    }
    pen.reach(pen.at + 4.0 * depth * n, pen.speed());
}

/// In, around, and out where it came in.
void loop(Pen& pen) {
    const std::size_t patch = pen.any_patch();
    const Vector3d n = pen.normal(patch), g = pen.any_point(patch);
    const double depth = pen.size_m * pen.scale(1e-3, kDeepest), side = pen.size_m * pen.scale(0.005, 0.1);
    const Vector3d one = side * pen.along(n), two = pen.between(-1, 1) * one + side * pen.between(-1, 1) * pen.along(n);
    const double speed = std::max(pen.speed(), side / (kTick_s * kMostTicksOfLine));
    pen.put(g + pen.size_m * 0.005 * n);
    pen.reach(g - depth * n, pen.speed());
    for (const Vector3d& to : {one, two, Vector3d(Vector3d::Zero())}) pen.reach(g - depth * n + to, speed);
    pen.reach(g + pen.size_m * 0.01 * n, pen.speed());
}

/// Straight through, from outside to outside.
void pass(Pen& pen) {
    const std::size_t first = pen.any_patch(), second = pen.any_patch();
    const Vector3d a = pen.any_point(first), b = pen.any_point(second);
    const Vector3d along = (b - a).norm() > 1e-3 * pen.size_m ? (b - a).normalized() : pen.direction();
    pen.put(a - pen.height() * along);
    const double speed = pen.between(1.0, kPass_m_s);
    pen.line(b + pen.size_m * kHigh * along, speed);
    if (pen.below(2) == 0) pen.line(a - pen.size_m * kHigh * along, speed);
}

/// A shaking hand at the surface, wandering a little.
void tremble(Pen& pen) {
    const std::size_t patch = pen.any_patch();
    const Vector3d n = pen.normal(patch), g = pen.any_point(patch);
    const double width = pen.size_m * pen.scale(1e-6, 5e-3), turns = pen.between(5.0, 250.0);
    const Vector3d drift = pen.scale(1e-3, 0.05) * kTick_s * (pen.along(n) + pen.between(-0.1, 0.1) * n);
    const bool regular = pen.below(2) == 0;
    pen.put(g + pen.size_m * 0.002 * n);
    const std::size_t ticks = 50 + pen.below(150);
    for (std::size_t i = 0; i < ticks; ++i) {
        const double t = static_cast<double>(i);
        const Vector3d shake = regular ? Vector3d(std::sin(2.0 * EIGEN_PI * turns * kTick_s * t) * n) : pen.direction();
        pen.put(g + t * drift + width * pen.between(0.5, 1.0) * shake);
    }
    pen.reach(pen.at + pen.size_m * kHigh * n, pen.speed());
}

/// In and out, from place to place.
void poke(Pen& pen) {
    std::size_t patch = pen.any_patch();
    const double depth = pen.depth();
    pen.put(pen.any_point(patch) + depth * pen.normal(patch));
    for (std::size_t turn = 2 + pen.below(5); turn > 0; --turn) {
        const Vector3d g = pen.any_point(patch), n = (pen.normal(patch) + 0.5 * pen.direction()).normalized();
        pen.line(g - depth * n, pen.speed());
        pen.line(g + depth * n, pen.speed());
        for (int hop = 0; hop < 3; ++hop) patch = pen.any_neighbour(patch);
    }
    pen.reach(pen.at + pen.size_m * kHigh * pen.normal(patch), pen.speed());
}

/// A session that starts with the finger in the body.
void begin_inside(Pen& pen) {
    const std::size_t patch = pen.any_patch();
    const Vector3d n = pen.normal(patch), g = pen.any_point(patch);
    const double depth = pen.depth();
    pen.put(g - depth * n);
    pen.line(pen.at + depth * pen.direction(), pen.speed());
    pen.line(g + depth * n, pen.speed());
    if (pen.below(2) == 0) pen.rest(1 + pen.below(3));
    pen.line(pen.any_point(pen.any_neighbour(patch)) - depth * n, pen.speed());
    pen.reach(g + pen.size_m * kHigh * n, pen.speed());
}

}  // namespace

std::array<float, 4> turn_of(const std::array<float, 3>& vector) {
    const double rest = 1.0 - to_vector(vector.data()).squaredNorm();
    return {static_cast<float>(std::sqrt(std::max(0.0, rest))), vector[0], vector[1], vector[2]};
}

StrokeMaker::StrokeMaker(const ServoModel& servo)
    : servo_(servo), size_m_(static_cast<double>(servo.tolerance_m) * 0x1p20) {
    double sum = 0.0;
    for (std::size_t p = 0; p < servo.patch.size(); ++p) area_.push_back(sum += twice_area(servo, p).norm());
}

Path StrokeMaker::path(std::uint64_t seed, std::uint64_t number) const {
    // As often as they stand here.
    static constexpr auto kKinds =
        std::to_array<void (*)(Pen&)>({slide, slide, slide, slide, follow, follow, follow, cross_edge, cross_edge,
                                       cross_edge, loop, loop, pass, tremble, poke, begin_inside});
    Pen pen{servo_, area_, size_m_, std::mt19937_64(mix(seed, number))};
    kKinds[pen.below(kKinds.size())](pen);
    return std::move(pen.path);
}

Stroke StrokeMaker::make(std::uint64_t seed, std::uint64_t number, int fingers) const {
    constexpr double kNear = 0.01, kFar = 0.2;  // of the body's size: fingers have one, too
    const auto apart = static_cast<std::uint64_t>(fingers > HAPTABLE_FINGERS ? HAPTABLE_HANDS : fingers);
    Pen pen{servo_, area_, size_m_, std::mt19937_64(mix(~seed, number))};
    const bool together = fingers > HAPTABLE_FINGERS && pen.below(2) == 0;
    const double spread_m = size_m_ * pen.scale(kNear, kFar);
    std::vector<Path> each;
    std::size_t ticks = 0;
    for (std::size_t f = 0; f < static_cast<std::size_t>(fingers); ++f) {
        const Vector3d aside = spread_m * pen.direction();
        each.push_back(together && f > 0 ? beside(each[0], aside) : path(seed, apart * number + f));
        ticks = std::max(ticks, each[f].size());
    }
    Stroke stroke(ticks);
    for (std::size_t i = 0; i < ticks; ++i)
        for (std::size_t f = 0; f < each.size(); ++f) stroke[i][f] = each[f][std::min(i, each[f].size() - 1)];
    return stroke;
}

Stroke StrokeMaker::make_poses(std::uint64_t seed, std::uint64_t number) const {
    constexpr double kFastest = 0.02, kSway = 2.0, kSlower = 0.3;  // rad a tick, rad
    Stroke stroke = make(seed, number, 1);
    Pen pen{servo_, area_, size_m_, std::mt19937_64(mix(~seed, number))};
    const Vector3d fast = kSway * pen.between(0.0, 1.0) * pen.direction();
    const Vector3d slow = pen.between(0.0, std::numbers::pi) * pen.direction();
    const double per_tick = pen.scale(0.01 * kFastest, kFastest);
    for (std::size_t i = 0; i < stroke.size(); ++i) {
        const double angle = per_tick * static_cast<double>(i);
        const Vector3d by = fast * std::sin(angle) + slow * std::cos(kSlower * angle);
        const Eigen::Quaterniond turn(Eigen::AngleAxisd(by.norm(), by.norm() > 0.0 ? by.normalized() : by));
        for (std::size_t c = 0; c < 3; ++c)
            stroke[i][1][c] = static_cast<float>(std::copysign(1.0, turn.w()) * turn.vec()[static_cast<int>(c)]);
    }
    return stroke;
}

std::string to_csv(const Stroke& stroke, int fingers) {
    std::string text = fingers == kToolHand ? "x,y,z,qw,qx,qy,qz" : "x,y,z";
    for (int f = 2; f <= fingers; ++f) text += fmt::format(",x{0},y{0},z{0}", f);
    text += "\n";
    for (const FingerPositions& x : stroke) {
        for (std::size_t f = 0; f < static_cast<std::size_t>(std::max(1, fingers)); ++f)
            text += fmt::format("{}{:.9g}", f > 0 ? "," : "", fmt::join(x[f], ","));
        if (fingers == kToolHand) text += fmt::format(",{:.9g}", fmt::join(turn_of(x[1]), ","));
        text += "\n";
    }
    return text;
}

Stroke read_stroke(const std::filesystem::path& file) {
    Stroke stroke;
    for (const FingerTick& tick : read_finger_ticks(file, Positions::any)) {
        FingerPositions& x = stroke.emplace_back();
        for (std::size_t f = 0; f < std::min(tick.fingers(), x.size()); ++f)
            std::copy_n(tick.finger(f).position_m.begin(), 3, x[f].begin());
        for (std::size_t c = 0; tick.turn && c < 3; ++c)
            x[1][c] = static_cast<float>(std::copysign(1.0, (*tick.turn)[0]) * (*tick.turn)[1 + c]);
    }
    return stroke;
}

}  // namespace haptable
