// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/vtu.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "host/base/file.hpp"
#include "host/base/index.hpp"
#include "host/base/vtu_text.hpp"

namespace haptable {

namespace {

/// Newtons at every drawn node.
std::vector<Eigen::Vector3f> nodal_forces(const DrawnSurface& surface, std::span<const NodalForce> loads) {
    std::vector<Eigen::Vector3f> force(surface.nodes(), Eigen::Vector3f::Zero());
    for (const NodalForce& load : loads) {
        const auto found = std::lower_bound(surface.node_id.begin(), surface.node_id.end(), load.node);
        if (found == surface.node_id.end() || *found != load.node) continue;
        force[at(found - surface.node_id.begin())] +=
            Eigen::Vector3f(load.force_n[0], load.force_n[1], load.force_n[2]);
    }
    return force;
}

}  // namespace

std::string vtu_text(const DrawnSurface& surface, std::span<const NodalForce> loads) {
    std::vector<Eigen::Vector3f> position_m = surface.rest_m;
    for (std::size_t i = 0; i < position_m.size(); ++i) position_m[i] += surface.displacement_m[i];
    std::vector<std::size_t> offset(surface.patches());
    for (std::size_t p = 0; p < offset.size(); ++p) offset[p] = 3 * (p + 1);
    VtuText out(surface.nodes(), surface.patches());
    out.section("PointData");
    out.array("Float32", "displacement_m", 3, surface.displacement_m);
    out.array("Float32", "force_n", 3, nodal_forces(surface, loads));
    out.array("Int32", "node", 1, surface.node_id);
    out.section("Points");
    out.array("Float32", "position_m", 3, position_m);
    out.section("CellData");
    out.array("UInt8", "touchable", 1, surface.touchable);
    out.section("Cells");
    out.array("Int32", "connectivity", 1, surface.patch);
    out.array("Int64", "offsets", 1, offset);
    out.array("UInt8", "types", 1, std::vector<std::uint8_t>(surface.patches(), kVtkTriangle));
    return out.finish();
}

std::string contact_text(const ContactFrame& frame) {
    std::vector<Eigen::Vector3f> position_m, force_n;
    std::vector<std::uint8_t> kind;
    const auto add = [&](VtuPoint what, const Eigen::Vector3d& at_m, const Eigen::Vector3d& n) {
        position_m.push_back(at_m.cast<float>());
        force_n.push_back(n.cast<float>());
        kind.push_back(static_cast<std::uint8_t>(what));
    };
    if (frame.finger_known) add(VtuPoint::finger, frame.finger_m, Eigen::Vector3d::Zero());
    if (frame.contact) add(VtuPoint::god_object, frame.god_object_m, frame.force_n);
    std::vector<std::size_t> number(kind.size()), offset(kind.size());
    std::iota(number.begin(), number.end(), 0U);
    std::iota(offset.begin(), offset.end(), 1U);
    VtuText out(kind.size(), kind.size());
    out.section("PointData");
    out.array("UInt8", "kind", 1, kind);
    out.array("Float32", "force_n", 3, force_n);
    out.section("Points");
    out.array("Float32", "position_m", 3, position_m);
    out.section("Cells");
    out.array("Int32", "connectivity", 1, number);
    out.array("Int64", "offsets", 1, offset);
    out.array("UInt8", "types", 1, std::vector<std::uint8_t>(kind.size(), kVtkVertex));
    return out.finish();
}

void VtuSeries::add(const DrawnSurface& surface, const ContactFrame& frame) {
    const std::size_t number = time_s_.size();
    write_file(folder_.file(frame_name(number) + ".vtu"), vtu_text(surface, frame.loads));
    write_file(folder_.file(contact_name(number) + ".vtu"), contact_text(frame));
    time_s_.push_back(frame.time_s);
}

void VtuSeries::close() const {
    std::string text =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
        "<Collection>\n";
    for (std::size_t frame = 0; frame < time_s_.size(); ++frame)
        for (const auto& [part, name] : {std::pair(0, frame_name(frame)), {1, contact_name(frame)}})
            text +=
                fmt::format("<DataSet timestep=\"{:.6f}\" part=\"{}\" file=\"{}.vtu\"/>\n", time_s_[frame], part, name);
    write_file(folder_.file("frames.pvd"), text + "</Collection>\n</VTKFile>\n");
}

std::string frame_name(std::size_t frame) { return fmt::format("frame_{:06}", frame); }

std::string contact_name(std::size_t frame) { return fmt::format("contact_{:06}", frame); }

}  // namespace haptable
