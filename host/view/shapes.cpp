// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/shapes.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace haptable {

namespace {

using Eigen::Vector3f;

constexpr int kAround = 32;  // facets around an axis
constexpr int kRings = 16;   // of the sphere, pole to pole

void add(std::vector<float>& out, const Vector3f& position, const Vector3f& normal) {
    out.insert(out.end(), {position.x(), position.y(), position.z(), normal.x(), normal.y(), normal.z()});
}

Vector3f around(int step, float radius, float z) {
    const float angle = 2.0F * static_cast<float>(std::numbers::pi) * static_cast<float>(step) / kAround;
    return {radius * std::cos(angle), radius * std::sin(angle), z};
}

/// A body of revolution: the ring (r0, z0) to the ring (r1, z1), normals (n0r, n0z) and (n1r, n1z).
void add_band(std::vector<float>& out, float r0, float z0, float n0r, float n0z, float r1, float z1, float n1r,
              float n1z) {
    for (int k = 0; k < kAround; ++k) {
        const Vector3f low[2] = {around(k, r0, z0), around(k + 1, r0, z0)};
        const Vector3f high[2] = {around(k, r1, z1), around(k + 1, r1, z1)};
        const Vector3f low_normal[2] = {around(k, n0r, n0z), around(k + 1, n0r, n0z)};
        const Vector3f high_normal[2] = {around(k, n1r, n1z), around(k + 1, n1r, n1z)};
        add(out, low[0], low_normal[0]);
        add(out, low[1], low_normal[1]);
        add(out, high[1], high_normal[1]);
        add(out, low[0], low_normal[0]);
        add(out, high[1], high_normal[1]);
        add(out, high[0], high_normal[0]);
    }
}

using Cells = std::vector<float>;

std::size_t cell_index(int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(Shadow::kCells) + static_cast<std::size_t>(x);
}

/// Darkness of the cells whose centre lies under a triangle, at least `dark`.
void fill_triangle(Cells& cells, const Eigen::Vector2f (&p)[3], float dark) {
    const auto bound = [](float v) { return std::clamp(static_cast<int>(std::floor(v)), 0, Shadow::kCells - 1); };
    const auto side = [](const Eigen::Vector2f& a, const Eigen::Vector2f& b, const Eigen::Vector2f& q) {
        return (b.x() - a.x()) * (q.y() - a.y()) - (b.y() - a.y()) * (q.x() - a.x());
    };
    for (int y = bound(std::min({p[0].y(), p[1].y(), p[2].y()})); y <= bound(std::max({p[0].y(), p[1].y(), p[2].y()}));
         ++y)
        for (int x = bound(std::min({p[0].x(), p[1].x(), p[2].x()}));
             x <= bound(std::max({p[0].x(), p[1].x(), p[2].x()})); ++x) {
            const Eigen::Vector2f q(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
            const float a = side(p[0], p[1], q), b = side(p[1], p[2], q), c = side(p[2], p[0], q);
            if (std::min({a, b, c}) < 0.0F && std::max({a, b, c}) > 0.0F) continue;
            float& cell = cells[cell_index(x, y)];
            cell = std::max(cell, dark);
        }
}

/// Means over 2 `reach` + 1 cells along one axis; three times this is nearly a Gaussian.
Cells blur(const Cells& cells, int reach, bool along_x) {
    Cells out(cells.size());
    for (int y = 0; y < Shadow::kCells; ++y)
        for (int x = 0; x < Shadow::kCells; ++x) {
            float sum = 0.0F;
            for (int d = -reach; d <= reach; ++d) {
                const int u = along_x ? x + d : x, v = along_x ? y : y + d;
                if (u >= 0 && u < Shadow::kCells && v >= 0 && v < Shadow::kCells) sum += cells[cell_index(u, v)];
            }
            out[cell_index(x, y)] = sum / static_cast<float>(2 * reach + 1);
        }
    return out;
}

}  // namespace

std::vector<float> sphere_shape() {
    std::vector<float> out;
    for (int ring = 0; ring < kRings; ++ring) {
        const float low = static_cast<float>(std::numbers::pi) * (static_cast<float>(ring) / kRings - 0.5F);
        const float high = static_cast<float>(std::numbers::pi) * (static_cast<float>(ring + 1) / kRings - 0.5F);
        add_band(out, std::cos(low), std::sin(low), std::cos(low), std::sin(low), std::cos(high), std::sin(high),
                 std::cos(high), std::sin(high));
    }
    return out;
}

std::vector<float> rod_shape() {
    std::vector<float> out;
    add_band(out, 0.0F, 0.0F, 0.0F, -1.0F, 1.0F, 0.0F, 0.0F, -1.0F);
    add_band(out, 1.0F, 0.0F, 1.0F, 0.0F, 1.0F, 1.0F, 1.0F, 0.0F);
    add_band(out, 1.0F, 1.0F, 0.0F, 1.0F, 0.0F, 1.0F, 0.0F, 1.0F);
    return out;
}

std::vector<float> cone_shape() {
    std::vector<float> out;
    const float slope = std::sqrt(0.5F);
    add_band(out, 0.0F, 0.0F, 0.0F, -1.0F, 1.0F, 0.0F, 0.0F, -1.0F);
    add_band(out, 1.0F, 0.0F, slope, slope, 0.0F, 1.0F, slope, slope);
    return out;
}

Shadow cast_shadow(const DrawnSurface& surface, std::span<const Vector3f> points_m, const Vector3f& low_m,
                   const Vector3f& high_m) {
    constexpr float kRoom = 0.12F;    // around the body, of its diagonal
    constexpr float kDarkest = 0.5F;  // opacity right under the body
    constexpr int kReach = Shadow::kCells / 36;
    const float size = (high_m - low_m).norm();
    Shadow shadow;
    shadow.side_m = (high_m - low_m).head<2>().maxCoeff() + 2.0F * kRoom * size;
    shadow.low_x_m = 0.5F * (low_m.x() + high_m.x() - shadow.side_m);
    shadow.low_y_m = 0.5F * (low_m.y() + high_m.y() - shadow.side_m);
    const float cells_per_m = Shadow::kCells / shadow.side_m;

    Cells cells(static_cast<std::size_t>(Shadow::kCells * Shadow::kCells), 0.0F);
    for (const Eigen::Vector3i& patch : surface.patch) {
        Eigen::Vector2f corner[3];
        float height = 0.0F;
        for (int c = 0; c < 3; ++c) {
            const Vector3f& p = points_m[static_cast<std::size_t>(patch[c])];
            corner[c] = {(p.x() - shadow.low_x_m) * cells_per_m, (p.y() - shadow.low_y_m) * cells_per_m};
            height += (p.z() - low_m.z()) / 3.0F;
        }
        fill_triangle(cells, corner, kDarkest * std::exp(-6.0F * height / size));
    }
    for (int pass = 0; pass < 3; ++pass) cells = blur(blur(cells, kReach, true), kReach, false);
    for (const float cell : cells) shadow.darkness.push_back(static_cast<std::uint8_t>(std::lround(255.0F * cell)));
    return shadow;
}

}  // namespace haptable
