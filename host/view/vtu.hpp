// SPDX-License-Identifier: GPL-2.0-or-later
// The deformed surfaces for ParaView.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "host/view/deformation.hpp"
#include "host/view/surface.hpp"

namespace haptable {

/// One unstructured grid of triangles: the surface as it is deformed now, with displacement (m), nodal force (N) and
/// mesh node of every point, and whether a patch may be touched.
std::string vtu_text(const DrawnSurface& surface, std::span<const NodalForce> loads);

/// A series of them in a folder, and the .pvd file that gives ParaView their times.
class VtuSeries {
public:
    explicit VtuSeries(std::filesystem::path folder) : folder_(std::move(folder)) {}
    void add(double time_s, const DrawnSurface& surface, std::span<const NodalForce> loads);
    /// Writes `folder`/frames.pvd.
    void close() const;

private:
    std::filesystem::path folder_;
    std::vector<double> time_s_;
};

/// frame_000012 for 12: the name of a frame's files without their suffix.
std::string frame_name(std::size_t frame);

}  // namespace haptable
