// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/target/strokes.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace haptable {

namespace {

using Vec = Eigen::Vector3d;

constexpr int kTicks = 40;         // of a stroke
constexpr double kDepth_m = 3e-3;  // of the stroke's middle, along the first patch's normal

/// Numbers that are the same on every machine (Knuth's MMIX generator, its high bits).
class Choice {
public:
    double uniform() { return static_cast<double>(below(std::size_t{1} << 31)) / 0x1p31; }
    /// A direction, evenly over the sphere (Archimedes).
    Vec direction() {
        const double z = 2.0 * uniform() - 1.0, angle = 2.0 * std::numbers::pi * uniform();
        const double r = std::sqrt(1.0 - z * z);
        return {r * std::cos(angle), r * std::sin(angle), z};
    }
    std::size_t below(std::size_t n) {
        state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
        return static_cast<std::size_t>((state_ >> 33) % n);
    }

private:
    std::uint64_t state_ = 1;
};

Vec corner(const Tables& tables, std::size_t patch, std::size_t c) {
    const auto& p = tables.position[static_cast<std::size_t>(tables.patch[patch][c])];
    return {p[0], p[1], p[2]};
}

Vec centre(const Tables& tables, std::size_t patch) {
    return (corner(tables, patch, 0) + corner(tables, patch, 1) + corner(tables, patch, 2)) / 3.0;
}

Vec normal(const Tables& tables, std::size_t patch) {
    const Vec a = corner(tables, patch, 0);
    return (corner(tables, patch, 1) - a).cross(corner(tables, patch, 2) - a).normalized();
}

/// The nearest to `from` of a few random patches: a stroke's end is near its begin, but not in the same patch.
std::size_t near_patch(const Tables& tables, std::size_t from, Choice& choice) {
    std::size_t best = choice.below(tables.patch.size());
    for (int tries = 0; tries < 8; ++tries) {
        const std::size_t other = choice.below(tables.patch.size());
        if (other == from) continue;
        if ((centre(tables, other) - centre(tables, from)).norm() <
            (centre(tables, best) - centre(tables, from)).norm())
            best = other;
    }
    return best;
}

}  // namespace

std::vector<std::array<float, 3>> stroke_path(const Tables& tables, int strokes) {
    std::vector<std::array<float, 3>> path;
    Choice choice;
    for (int stroke = 0; stroke < strokes; ++stroke) {
        const std::size_t begin = choice.below(tables.patch.size());
        const std::size_t end = near_patch(tables, begin, choice);
        const Vec from = centre(tables, begin), outward = normal(tables, begin);
        const Vec to = stroke % 4 == 0 ? corner(tables, end, 0) : centre(tables, end);
        for (int tick = 0; tick < kTicks; ++tick) {
            const double s = tick / (kTicks - 1.0);
            // 1 mm outside at the ends, kDepth_m inside in the middle.
            const double height_m = 1e-3 - (kDepth_m + 1e-3) * std::sin(std::numbers::pi * s);
            const Eigen::Vector3f at = (from + s * (to - from) + height_m * outward).cast<float>();
            path.push_back({at[0], at[1], at[2]});
        }
    }
    return path;
}

std::vector<std::array<float, 3>> hard_path(const Tables& tables, int strokes) {
    constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
    std::vector<std::array<float, 3>> path;
    Choice choice;
    for (int stroke = 0; stroke < strokes; ++stroke) {
        const std::size_t patch = choice.below(tables.patch.size());
        const Vec n = normal(tables, patch);
        Vec alpha(choice.uniform(), choice.uniform(), choice.uniform());
        alpha /= alpha.sum();
        const double step_m = 1e-3 * 0.01 * std::pow(500.0, choice.uniform());
        Vec x = (step_m * choice.uniform() + 2e-6) * n, in = choice.direction(), aside = choice.direction();
        for (std::size_t c = 0; c < 3; ++c) x += alpha[static_cast<Eigen::Index>(c)] * corner(tables, patch, c);
        if (in.dot(n) > 0.0) in = -in;
        in = (in - 0.5 * n).normalized();
        path.push_back({kNone, kNone, kNone});
        for (int tick = 0; tick < 19; ++tick) {
            const Eigen::Vector3f at = x.cast<float>();
            path.push_back({at[0], at[1], at[2]});
            x += 0.999 * step_m * (tick < 10 ? in : aside);
        }
    }
    return path;
}

std::vector<std::array<float, 6>> of_two(const std::vector<std::array<float, 3>>& path_m, int strokes) {
    const std::size_t apart = path_m.size() / static_cast<std::size_t>(strokes) * static_cast<std::size_t>(strokes / 2);
    std::vector<std::array<float, 6>> both;
    for (std::size_t i = 0; i < path_m.size(); ++i) {
        const std::array<float, 3>&a = path_m[i], &b = path_m[(i + apart) % path_m.size()];
        both.push_back({a[0], a[1], a[2], b[0], b[1], b[2]});
    }
    return both;
}

std::vector<std::array<float, 6>> poses_of(const std::vector<std::array<float, 3>>& path_m) {
    std::vector<std::array<float, 6>> poses;
    for (const auto& x : path_m) {
        const auto tick = static_cast<float>(poses.size());
        const auto by = [tick](float per_tick) { return 0.4F * std::sin(per_tick * tick); };  // of 1: half an angle's
        poses.push_back({x[0], x[1], x[2], by(0.01F), by(0.013F), by(0.017F)});
    }
    return poses;
}

std::vector<std::array<float, 3>> tip_path() {
    std::vector<std::array<float, 3>> path;
    for (int tick = 0; tick < 300; ++tick)
        path.push_back({0.015F, 0.0151F, 0.0325F - 2e-5F * static_cast<float>(tick)});
    for (int tick = 0; tick < 1000; ++tick)
        path.push_back({0.015F + 2e-5F * static_cast<float>(tick), 0.0151F, 0.0265F});
    path[1250] = {std::numeric_limits<float>::quiet_NaN(), 0.0F, 0.0F};
    return path;
}

std::vector<std::array<float, 6>> grasp_path() {
    std::vector<std::array<float, 6>> path;
    for (int tick = 0; tick < 950; ++tick) {
        const float t = static_cast<float>(tick);
        const float in_m = tick < 800 ? std::clamp(-0.002F + 2e-5F * (t - 100.0F), -0.002F, 0.0025F) : -0.002F;
        const float up_m = std::clamp(5e-5F * (t - 350.0F), 0.0F, 0.02F);
        path.push_back({in_m, 0.015F, 0.02F + up_m, 0.03F - in_m, 0.015F, 0.02F + up_m});
    }
    path[900][3] = std::numeric_limits<float>::quiet_NaN();
    return path;
}

std::vector<std::array<float, 6>> squeeze_path() {
    std::vector<std::array<float, 6>> path;
    for (int tick = 0; tick < 300; ++tick) {
        const float in_m = 0.0025F - 0.004F * std::cos(0.042F * static_cast<float>(tick));
        path.push_back({in_m, 0.0151F, 0.021F, 0.03F - in_m, 0.0147F, 0.022F});
    }
    for (int tick = 0; tick < 300; ++tick) {
        const float t = static_cast<float>(tick), aside_m = 2e-5F * std::max(0.0F, t - 150.0F);
        const float first_m = std::max(0.028F, 0.032F - 5e-5F * t), second_m = std::max(0.0285F, 0.034F - 5e-5F * t);
        path.push_back({0.0117F - aside_m, 0.0168F, first_m, 0.0181F + aside_m, 0.0131F, second_m});
    }
    path[550][3] = std::numeric_limits<float>::quiet_NaN();
    return path;
}

std::vector<std::array<float, 3>> knock_path() {
    std::vector<std::array<float, 3>> path;
    for (int tick = 0; tick < 300; ++tick)
        path.push_back({0.0137F, 0.0168F, 0.029F + 0.003F * std::cos(0.063F * static_cast<float>(tick))});
    for (int tick = 0; tick < 300; ++tick)
        path.push_back({0.0137F + 2e-5F * static_cast<float>(tick), 0.0168F, 0.028F});
    path[450] = {std::numeric_limits<float>::quiet_NaN(), 0.0F, 0.0F};
    return path;
}

}  // namespace haptable
