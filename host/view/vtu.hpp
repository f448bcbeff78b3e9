// SPDX-License-Identifier: GPL-2.0-or-later
// The deformed surfaces for ParaView.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "host/base/own_folder.hpp"
#include "host/view/deformation.hpp"
#include "host/view/frame.hpp"
#include "host/view/surface.hpp"

namespace haptable {

/// One unstructured grid of triangles: the surface as it is deformed now, with displacement (m), nodal force (N) and
/// mesh node of every point, and whether a patch may be touched.
std::string vtu_text(const DrawnSurface& surface, std::span<const NodalForce> loads);

/// `kind` of a point.
enum class VtuPoint : std::uint8_t { finger = 0, god_object = 1 };

/// One unstructured grid of points: the finger where it is known, the god-object of a contact with the force on the
/// finger (N).
std::string contact_text(const ContactFrame& frame);

/// A series of both in a folder, and the .pvd file that gives ParaView their times.
class VtuSeries {
public:
    explicit VtuSeries(OwnFolder& folder) : folder_(folder) {}
    void add(const DrawnSurface& surface, const ContactFrame& frame);
    /// Writes `folder`/frames.pvd.
    void close() const;

private:
    OwnFolder& folder_;
    std::vector<double> time_s_;
};

/// frame_000012 for 12: the name of a frame's files without their suffix.
std::string frame_name(std::size_t frame);
/// contact_000012, of the points.
std::string contact_name(std::size_t frame);

}  // namespace haptable
