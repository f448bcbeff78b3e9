// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/vtu.hpp"

#include <fmt/format.h>

#include <iterator>
#include <span>

namespace haptable {

namespace {

// VTK's numbers of the cell types.
constexpr int kVtkTriangle = 5;
constexpr int kVtkTetra = 10;

/// Text with one <DataArray> after another.
class Writer {
public:
    template <typename... Args>
    void line(fmt::format_string<Args...> format, Args&&... args) {
        fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
        text_.push_back('\n');
    }
    void begin_array(const char* type, const char* name, int components = 1) {
        line(R"(<DataArray type="{}" Name="{}" NumberOfComponents="{}" format="ascii">)", type, name, components);
    }
    void end_array() { line("</DataArray>"); }
    void flags(const char* name, std::span<const char> values) {
        begin_array("UInt8", name);
        for (char value : values) line("{}", static_cast<int>(value));
        end_array();
    }
    std::string take() { return fmt::to_string(text_); }

private:
    fmt::memory_buffer text_;
};

std::vector<char> flags_of(const std::vector<std::int32_t>& nodes, std::size_t node_count) {
    std::vector<char> flags(node_count, 0);
    for (std::int32_t node : nodes) flags[static_cast<std::size_t>(node)] = 1;
    return flags;
}

void write_points(const Body& body, Writer& out) {
    const std::size_t node_count = body.mesh.position_m.size();
    std::vector<char> fixed(node_count);
    for (std::size_t i = 0; i < node_count; ++i) fixed[i] = body.is_fixed(static_cast<std::int32_t>(i)) ? 1 : 0;
    out.line("<PointData>");
    out.flags("fixed", fixed);
    out.flags("surface", flags_of(body.surface.node, node_count));
    out.flags("touchable", flags_of(body.touch_node, node_count));
    out.line("</PointData>");
    out.line("<Points>");
    out.begin_array("Float64", "Points", 3);
    for (const Eigen::Vector3d& p : body.mesh.position_m) out.line("{} {} {}", p.x(), p.y(), p.z());
    out.end_array();
    out.line("</Points>");
}

void write_cells(const Body& body, Writer& out) {
    const std::vector<Tet>& tets = body.mesh.tet;
    const std::vector<Patch>& patches = body.touch_patch;
    out.line("<Cells>");
    out.begin_array("Int32", "connectivity");
    for (const Tet& tet : tets) out.line("{}", fmt::join(tet, " "));
    for (const Patch& patch : patches) out.line("{}", fmt::join(patch, " "));
    out.end_array();
    out.begin_array("Int64", "offsets");
    for (std::size_t t = 1; t <= tets.size(); ++t) out.line("{}", 4 * t);
    for (std::size_t p = 1; p <= patches.size(); ++p) out.line("{}", 4 * tets.size() + 3 * p);
    out.end_array();
    out.begin_array("UInt8", "types");
    for (std::size_t t = 0; t < tets.size(); ++t) out.line("{}", kVtkTetra);
    for (std::size_t p = 0; p < patches.size(); ++p) out.line("{}", kVtkTriangle);
    out.end_array();
    out.line("</Cells>");
}

}  // namespace

std::string to_vtu(const Body& body) {
    Writer out;
    out.line(R"(<?xml version="1.0"?>)");
    out.line(R"(<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">)");
    out.line("<UnstructuredGrid>");
    out.line(R"(<Piece NumberOfPoints="{}" NumberOfCells="{}">)", body.mesh.position_m.size(),
             body.mesh.tet.size() + body.touch_patch.size());
    write_points(body, out);
    std::vector<char> is_patch(body.mesh.tet.size(), 0);
    is_patch.resize(body.mesh.tet.size() + body.touch_patch.size(), 1);
    out.line("<CellData>");
    out.flags("touchable_patch", is_patch);
    out.line("</CellData>");
    write_cells(body, out);
    out.line("</Piece>");
    out.line("</UnstructuredGrid>");
    out.line("</VTKFile>");
    return out.take();
}

}  // namespace haptable
