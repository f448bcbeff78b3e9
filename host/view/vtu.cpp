// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/vtu.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "host/base/file.hpp"

namespace haptable {

namespace {

constexpr int kTriangle = 5;  // VTK_TRIANGLE

using Out = std::back_insert_iterator<std::string>;

template <typename Values, typename Write>
void array(std::string& text, const char* attributes, const Values& values, const Write& write) {
    text += fmt::format("<DataArray {} format=\"ascii\">\n", attributes);
    for (const auto& value : values) write(Out(text), value);
    text += "</DataArray>\n";
}

void vectors(std::string& text, const char* name, const std::vector<Eigen::Vector3f>& values) {
    const std::string attributes = fmt::format("type=\"Float32\" Name=\"{}\" NumberOfComponents=\"3\"", name);
    array(text, attributes.c_str(), values, [](Out out, const Eigen::Vector3f& v) {
        fmt::format_to(out, "{:.9g} {:.9g} {:.9g}\n", v.x(), v.y(), v.z());
    });
}

void points(std::string& text, const DrawnSurface& surface, std::span<const NodalForce> loads) {
    std::vector<Eigen::Vector3f> at = surface.rest_m;
    std::vector<Eigen::Vector3f> force(surface.nodes(), Eigen::Vector3f::Zero());
    for (std::size_t i = 0; i < at.size(); ++i) at[i] += surface.displacement_m[i];
    for (const NodalForce& load : loads) {
        const auto found = std::lower_bound(surface.node_id.begin(), surface.node_id.end(), load.node);
        if (found == surface.node_id.end() || *found != load.node) continue;
        force[static_cast<std::size_t>(found - surface.node_id.begin())] +=
            Eigen::Vector3f(load.force_n[0], load.force_n[1], load.force_n[2]);
    }
    text += "<PointData Vectors=\"displacement_m\">\n";
    vectors(text, "displacement_m", surface.displacement_m);
    vectors(text, "force_n", force);
    array(text, "type=\"Int32\" Name=\"node\"", surface.node_id,
          [](Out out, std::int32_t node) { fmt::format_to(out, "{}\n", node); });
    text += "</PointData>\n<Points>\n";
    vectors(text, "position_m", at);
    text += "</Points>\n";
}

void cells(std::string& text, const DrawnSurface& surface) {
    text += "<CellData>\n";
    array(text, "type=\"UInt8\" Name=\"touchable\"", surface.touchable,
          [](Out out, std::uint8_t touchable) { fmt::format_to(out, "{}\n", touchable); });
    text += "</CellData>\n<Cells>\n";
    array(text, "type=\"Int32\" Name=\"connectivity\"", surface.patch,
          [](Out out, const Eigen::Vector3i& p) { fmt::format_to(out, "{} {} {}\n", p.x(), p.y(), p.z()); });
    std::size_t offset = 0;
    array(text, "type=\"Int32\" Name=\"offsets\"", surface.patch,
          [&offset](Out out, const Eigen::Vector3i&) { fmt::format_to(out, "{}\n", offset += 3); });
    array(text, "type=\"UInt8\" Name=\"types\"", surface.patch,
          [](Out out, const Eigen::Vector3i&) { fmt::format_to(out, "{}\n", kTriangle); });
    text += "</Cells>\n";
}

}  // namespace

std::string vtu_text(const DrawnSurface& surface, std::span<const NodalForce> loads) {
    std::string text =
        "<?xml version=\"1.0\"?>\n"
        "<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n";
    text += fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", surface.nodes(), surface.patches());
    points(text, surface, loads);
    cells(text, surface);
    return text + "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

void VtuSeries::add(double time_s, const DrawnSurface& surface, std::span<const NodalForce> loads) {
    write_file(folder_ / (frame_name(time_s_.size()) + ".vtu"), vtu_text(surface, loads));
    time_s_.push_back(time_s);
}

void VtuSeries::close() const {
    std::string text =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
        "<Collection>\n";
    for (std::size_t frame = 0; frame < time_s_.size(); ++frame)
        text += fmt::format("<DataSet timestep=\"{:.6f}\" part=\"0\" file=\"{}.vtu\"/>\n", time_s_[frame],
                            frame_name(frame));
    write_file(folder_ / "frames.pvd", text + "</Collection>\n</VTKFile>\n");
}

std::string frame_name(std::size_t frame) { return fmt::format("frame_{:06}", frame); }

}  // namespace haptable
