// SPDX-License-Identifier: GPL-2.0-or-later
// The solid shapes of the markers, as triangles with normals, and the body's shadow on the ground.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/view/surface.hpp"

namespace haptable {

/// Unit sphere. Every shape: six floats a vertex, position and normal, three vertices a triangle.
std::vector<float> sphere_shape();
/// Radius 1 around the z axis, from z = 0 to z = 1, closed.
std::vector<float> rod_shape();
/// Radius 1 at z = 0, tip at z = 1, closed.
std::vector<float> cone_shape();

/// A square piece of ground and how dark the body makes it.
struct Shadow {
    static constexpr int kCells = 128;
    float low_x_m, low_y_m, side_m;
    std::vector<std::uint8_t> darkness;  ///< [kCells, kCells], x fastest
};

/// The footprint of the rest shape, darker where the body is near the ground, blurred.
/// points_m: [m] of the surface's nodes, z up; low_m, high_m: their box.
Shadow cast_shadow(const DrawnSurface& surface, std::span<const Eigen::Vector3f> points_m, const Eigen::Vector3f& low_m,
                   const Eigen::Vector3f& high_m);

}  // namespace haptable
