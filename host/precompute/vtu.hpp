// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <string>

#include "host/body/body.hpp"

namespace haptable {

/// The body as VTK XML (UnstructuredGrid, numbers as text), for ParaView. Cells: all tetrahedra, then the touchable
/// patches. Point data fixed, surface, touchable; cell data touchable_patch: each 0 or 1. Where the
/// scene has regions also theirs, region, numbered from 0, or -1. Of materials that are
/// not isotropic also their directions, material_axis_1 to 3; point data membrane and
/// bed where there are some, and sag (m), the displacement under the body's own weight.
///   sag_m  [N] or empty
std::string to_vtu(const Scene& scene, const Body& body, std::span<const Eigen::Vector3d> sag_m = {});

}  // namespace haptable
