// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/strokes/stroke.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

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

}  // namespace

std::array<float, 4> turn_of(const std::array<float, 3>& vector) {
    const double rest = 1.0 - to_vector(vector.data()).squaredNorm();
    return {static_cast<float>(std::sqrt(std::max(0.0, rest))), vector[0], vector[1], vector[2]};
}

/// A finger on its way, and its dice.
struct StrokeMaker::Pen {
    std::mt19937_64 dice;
    Path path;
    Vector3d at = Vector3d::Zero();

    double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(dice); }
    double scale(double low, double high) { return std::exp(between(std::log(low), std::log(high))); }
    std::size_t below(std::size_t count) { return std::uniform_int_distribution<std::size_t>(0, count - 1)(dice); }
    double speed() { return scale(kSlowest_m_s, kFastest_m_s); }
    Vector3d direction() {
        for (;;) {
            const Vector3d d(between(-1, 1), between(-1, 1), between(-1, 1));
            if (d.norm() < 1.0 && d.norm() > 0.1) return d.normalized();
        }
    }
    Vector3d along(const Vector3d& normal) { return direction().cross(normal).normalized(); }

    void put(const Vector3d& x) {
        at = x;
        path.push_back({static_cast<float>(x.x()), static_cast<float>(x.y()), static_cast<float>(x.z())});
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

StrokeMaker::StrokeMaker(const ServoModel& servo)
    : servo_(servo), size_m_(static_cast<double>(servo.tolerance_m) * 0x1p20) {
    double sum = 0.0;
    for (std::size_t p = 0; p < servo.patch.size(); ++p) {
        sum += (corner(p, 1) - corner(p, 0)).cross(corner(p, 2) - corner(p, 0)).norm();
        area_.push_back(sum);
    }
}

Vector3d StrokeMaker::corner(std::size_t patch, std::size_t c) const {
    return to_vector(servo_.vertex_m[servo_.patch[patch][c]].data());
}

Vector3d StrokeMaker::normal(std::size_t patch) const {
    return (corner(patch, 1) - corner(patch, 0)).cross(corner(patch, 2) - corner(patch, 0)).normalized();
}

/// Everywhere on the surface as often as on any patch, however small.
std::size_t StrokeMaker::any_patch(Pen& pen) const {
    if (pen.below(2) == 0) return pen.below(area_.size());
    const auto at = std::lower_bound(area_.begin(), area_.end(), pen.between(0.0, area_.back()));
    return static_cast<std::size_t>(std::min(at, area_.end() - 1) - area_.begin());
}

/// Inside, or, one in four, on an edge or a vertex.
Vector3d StrokeMaker::any_point(std::size_t patch, Pen& pen) const {
    Vector3d alpha(pen.between(0, 1), pen.between(0, 1), pen.between(0, 1));
    if (pen.below(4) == 0) alpha[static_cast<Eigen::Index>(pen.below(3))] = 0.0;
    if (pen.below(16) == 0) alpha = Vector3d::Unit(static_cast<Eigen::Index>(pen.below(3)));
    alpha /= alpha.sum();
    return alpha[0] * corner(patch, 0) + alpha[1] * corner(patch, 1) + alpha[2] * corner(patch, 2);
}

std::size_t StrokeMaker::any_neighbour(std::size_t patch, Pen& pen) const {
    const std::uint16_t next = servo_.neighbour[patch][pen.below(3)];
    return next == HAPTABLE_NONE ? patch : next;
}

/// Sharpness of the edge opposite to a corner: 0 where it is flat, 2 where it is a knife's.
double StrokeMaker::sharpness(std::size_t patch, std::size_t corner) const {
    const std::uint16_t across = servo_.neighbour[patch][corner];
    return across == HAPTABLE_NONE ? 0.0 : 1.0 - normal(patch).dot(normal(across));
}

/// In along the normal, straight ways at that depth, out along the normal of the begin.
void StrokeMaker::slide(Pen& pen) const {
    const std::size_t patch = any_patch(pen);
    const Vector3d n = normal(patch), g = any_point(patch, pen);
    const double depth = size_m_ * pen.scale(kShallow, kDeepest), high = size_m_ * pen.scale(kShallow, kHigh);
    pen.put(g + high * n);
    pen.reach(g - depth * n, pen.speed());
    for (std::size_t turn = 1 + pen.below(5); turn > 0; --turn) {
        pen.line(pen.at + size_m_ * pen.scale(0.01, 0.5) * pen.along(n), pen.speed());
        if (pen.below(4) == 0) pen.rest(1 + pen.below(5));
    }
    pen.reach(pen.at + (depth + 2.0 * high) * n, pen.speed());
}

/// From patch to neighbouring patch, at a depth under each: over edges and into creases.
void StrokeMaker::follow(Pen& pen) const {
    std::size_t patch = any_patch(pen);
    const double depth = size_m_ * pen.scale(kShallow, kDeepest), speed = pen.speed();
    pen.put(any_point(patch, pen) + size_m_ * pen.scale(kShallow, kHigh) * normal(patch));
    for (std::size_t steps = 2 + pen.below(14); steps > 0; --steps) {
        pen.line(any_point(patch, pen) - depth * normal(patch), speed);
        patch = any_neighbour(patch, pen);
    }
    pen.reach(pen.at + (depth + size_m_ * kHigh) * normal(patch), pen.speed());
}

/// Square to the sharpest of a few edges, to both sides of it.
void StrokeMaker::cross_edge(Pen& pen) const {
    std::size_t patch = any_patch(pen), c = pen.below(3);
    for (int tries = 0; tries < 8; ++tries) {
        const std::size_t p = any_patch(pen), k = pen.below(3);
        if (sharpness(p, k) > sharpness(patch, c)) patch = p, c = k;
    }
    const Vector3d a = corner(patch, (c + 1) % 3), b = corner(patch, (c + 2) % 3), n = normal(patch);
    const Vector3d middle = a + pen.between(0.0, 1.0) * (b - a), across = (b - a).cross(n).normalized();
    const double depth = size_m_ * pen.scale(kShallow, kDeepest), reach = size_m_ * pen.scale(0.005, 0.1);
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
void StrokeMaker::loop(Pen& pen) const {
    const std::size_t patch = any_patch(pen);
    const Vector3d n = normal(patch), g = any_point(patch, pen);
    const double depth = size_m_ * pen.scale(1e-3, kDeepest), side = size_m_ * pen.scale(0.005, 0.1);
    const Vector3d one = side * pen.along(n), two = pen.between(-1, 1) * one + side * pen.between(-1, 1) * pen.along(n);
    const double speed = std::max(pen.speed(), side / (kTick_s * kMostTicksOfLine));
    pen.put(g + size_m_ * 0.005 * n);
    pen.reach(g - depth * n, pen.speed());
    for (const Vector3d& to : {one, two, Vector3d(Vector3d::Zero())}) pen.reach(g - depth * n + to, speed);
    pen.reach(g + size_m_ * 0.01 * n, pen.speed());
}

/// Straight through, from outside to outside.
void StrokeMaker::pass(Pen& pen) const {
    const std::size_t first = any_patch(pen), second = any_patch(pen);
    const Vector3d a = any_point(first, pen), b = any_point(second, pen);
    const Vector3d along = (b - a).norm() > 1e-3 * size_m_ ? (b - a).normalized() : pen.direction();
    pen.put(a - size_m_ * pen.scale(kShallow, kHigh) * along);
    const double speed = pen.between(1.0, kPass_m_s);
    pen.line(b + size_m_ * kHigh * along, speed);
    if (pen.below(2) == 0) pen.line(a - size_m_ * kHigh * along, speed);
}

/// A shaking hand at the surface, wandering a little.
void StrokeMaker::tremble(Pen& pen) const {
    const std::size_t patch = any_patch(pen);
    const Vector3d n = normal(patch), g = any_point(patch, pen);
    const double width = size_m_ * pen.scale(1e-6, 5e-3), turns = pen.between(5.0, 250.0);
    const Vector3d drift = pen.scale(1e-3, 0.05) * kTick_s * (pen.along(n) + pen.between(-0.1, 0.1) * n);
    const bool regular = pen.below(2) == 0;
    pen.put(g + size_m_ * 0.002 * n);
    const std::size_t ticks = 50 + pen.below(150);
    for (std::size_t i = 0; i < ticks; ++i) {
        const double t = static_cast<double>(i);
        const Vector3d shake = regular ? Vector3d(std::sin(2.0 * EIGEN_PI * turns * kTick_s * t) * n) : pen.direction();
        pen.put(g + t * drift + width * pen.between(0.5, 1.0) * shake);
    }
    pen.reach(pen.at + size_m_ * kHigh * n, pen.speed());
}

/// In and out, from place to place.
void StrokeMaker::poke(Pen& pen) const {
    std::size_t patch = any_patch(pen);
    const double depth = size_m_ * pen.scale(kShallow, kDeepest);
    pen.put(any_point(patch, pen) + depth * normal(patch));
    for (std::size_t turn = 2 + pen.below(5); turn > 0; --turn) {
        const Vector3d g = any_point(patch, pen), n = (normal(patch) + 0.5 * pen.direction()).normalized();
        pen.line(g - depth * n, pen.speed());
        pen.line(g + depth * n, pen.speed());
        for (int hop = 0; hop < 3; ++hop) patch = any_neighbour(patch, pen);
    }
    pen.reach(pen.at + size_m_ * kHigh * normal(patch), pen.speed());
}

/// A session that starts with the finger in the body.
void StrokeMaker::begin_inside(Pen& pen) const {
    const std::size_t patch = any_patch(pen);
    const Vector3d n = normal(patch), g = any_point(patch, pen);
    const double depth = size_m_ * pen.scale(kShallow, kDeepest);
    pen.put(g - depth * n);
    pen.line(pen.at + depth * pen.direction(), pen.speed());
    pen.line(g + depth * n, pen.speed());
    if (pen.below(2) == 0) pen.rest(1 + pen.below(3));
    pen.line(any_point(any_neighbour(patch, pen), pen) - depth * n, pen.speed());
    pen.reach(g + size_m_ * kHigh * n, pen.speed());
}

StrokeMaker::Path StrokeMaker::path(std::uint64_t seed, std::uint64_t number) const {
    using Kind = void (StrokeMaker::*)(Pen&) const;
    // As often as they stand here.
    static constexpr std::array<Kind, 16> kKinds{
        &StrokeMaker::slide,      &StrokeMaker::slide,      &StrokeMaker::slide,  &StrokeMaker::slide,
        &StrokeMaker::follow,     &StrokeMaker::follow,     &StrokeMaker::follow, &StrokeMaker::cross_edge,
        &StrokeMaker::cross_edge, &StrokeMaker::cross_edge, &StrokeMaker::loop,   &StrokeMaker::loop,
        &StrokeMaker::pass,       &StrokeMaker::tremble,    &StrokeMaker::poke,   &StrokeMaker::begin_inside,
    };
    Pen pen{std::mt19937_64(mix(seed, number)), {}, Vector3d::Zero()};
    (this->*kKinds[pen.below(kKinds.size())])(pen);
    return std::move(pen.path);
}

Stroke StrokeMaker::make(std::uint64_t seed, std::uint64_t number, int fingers) const {
    Stroke stroke;
    if (fingers == 1) {
        for (const auto& x : path(seed, number)) stroke.push_back({x, {}});
        return stroke;
    }
    const Path first = path(seed, 2 * number), second = path(seed, 2 * number + 1);
    for (std::size_t i = 0; i < std::max(first.size(), second.size()); ++i)
        stroke.push_back({first[std::min(i, first.size() - 1)], second[std::min(i, second.size() - 1)]});
    return stroke;
}

Stroke StrokeMaker::make_poses(std::uint64_t seed, std::uint64_t number) const {
    constexpr double kFastest = 0.02, kSway = 2.0, kSlower = 0.3;  // rad a tick, rad
    Stroke stroke = make(seed, number, 1);
    Pen pen{std::mt19937_64(mix(~seed, number)), {}, Vector3d::Zero()};
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

}  // namespace haptable
