// SPDX-License-Identifier: GPL-2.0-or-later
// A tool's shape as points, each with the scene's pressure mask.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "host/scene/scene.hpp"

namespace haptable {

/// Points of a tool, m, about its handle in its own axes.
struct ToolSample {
    std::vector<Eigen::Vector3d> point_m;
    double spacing_m = 0.0;                                 ///< between points of a hexagonal grid that is as dense
    std::vector<std::array<Eigen::Vector3d, 3>> surface_m;  ///< triangles of the shape, as it is drawn
};

/// Samples the side of the shape whose normals are within `angle` of -z. Spheres and capsules are sampled by a spiral
/// of equal areas, whose points meet a dent one after the other; discs and meshes by points that repel each other
/// (Riesz's energy), the outermost 0.27 of the spacing within the border, as a flat face wants. A point's depth is to
/// be the mask's mean of the tool's profile: so each point stands back by that mean, mask_radius^2 (k1 + k2) / 16 for
/// curvatures k1 and k2. Within 5 % of Hertz and of a flat punch on a half-space with masks of 0.7 to 0.8 of the
/// spacing (docs/TOOL.md).
///   mask_radius_m  of [contact], 0: none
/// Throws Error that names the file of a mesh, or the key, where there is nothing to sample.
ToolSample sample_tool(const ToolShape& shape, double mask_radius_m);

/// Fills in the tool's points, and a torque that the motors have where the scene does not say: that of max_force at the
/// farthest point. A scene without a tool stays as it is. Throws Error as sample_tool, and where all points are the
/// handle.
ToolSample complete_tool(Scene& scene);

/// "12 points, 3.3 mm apart, each with a mask of 0.70 of that", and what to mend where the masks do not fit; of given
/// points their number.
std::string describe_tool(const Scene& scene, const ToolSample& sample);

}  // namespace haptable
