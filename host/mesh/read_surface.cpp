// SPDX-License-Identifier: GPL-2.0-or-later
// STL, OBJ, PLY and OFF by CGAL's readers, in a process of their own as every reader that we did not write.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "host/base/error.hpp"
#include "host/mesh/in_child.hpp"
#include "host/mesh/modules.hpp"
#include "host/mesh/pack.hpp"
#include "host/mesh/readers.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kCgalLeast_bytes = std::size_t{512} << 20;
constexpr std::size_t kCgalPerByte = 40;
constexpr unsigned kCgalCpu_s = 60;

/// Binary: 80 bytes of anything, a count, 50 bytes a triangle. Text has facets, whatever its first line says.
void check_stl(const fs::path& file, std::string_view text) {
    if (text.substr(0, 4096).find("facet") != std::string_view::npos) return refuse_comma_decimals(file, text);
    if (text.size() < 84) fail(file, "is neither a text STL (no facet) nor a binary one (84 bytes at the least)");
    std::uint32_t count = 0;
    std::memcpy(&count, text.data() + 80, sizeof count);
    if (84 + 50 * std::uint64_t{count} != text.size())
        fail(file, fmt::format("binary STL promises {} triangles ({} bytes), the file has {} bytes: it is damaged",
                               count, 84 + 50 * std::uint64_t{count}, text.size()));
}

RawMesh read_surface(const fs::path& file, std::string_view text, SurfaceKind kind) {
    if (kind == SurfaceKind::kStl) check_stl(file, text);
    const ChildLimits limits{kCgalLeast_bytes + kCgalPerByte * text.size(),
                             kCgalCpu_s + static_cast<unsigned>(text.size() >> 20)};
    const auto read = from_module<decltype(haptable_cgal_read)>(file, "haptable-cgal", "haptable_cgal_read");
    const std::string bytes = run_in_child(file.string(), limits, [&] {
        std::string packed;
        read(file, text, kind, packed);
        return packed;
    });
    Unpacker in(bytes);
    const auto coordinate = in.list<double>();
    const auto corner = in.list<Tag>();
    RawMesh raw;
    for (std::size_t k = 0; k + 2 < coordinate.size(); k += 3) {
        raw.node_tag.push_back(k / 3);
        raw.position.emplace_back(coordinate[k], coordinate[k + 1], coordinate[k + 2]);
    }
    for (std::size_t k = 0; k + 2 < corner.size(); k += 3)
        raw.triangle.push_back({corner[k], corner[k + 1], corner[k + 2]});
    raw.surface_elements = raw.triangle.size();
    return raw;
}

/// Text that begins with "solid" and has facets, or a binary whose size its count of triangles tells.
bool has_facets(std::string_view text) {
    std::uint32_t count = 0;
    if (text.size() >= 84) std::memcpy(&count, text.data() + 80, sizeof count);
    if (text.size() >= 84 && text.size() == 84 + 50 * std::size_t{count}) return true;
    return text.starts_with("solid") && text.substr(0, 4096).find("facet") != std::string_view::npos;
}

}  // namespace

/// The first line that is no comment begins with one of the words of Wavefront's format.
bool is_obj(const MeshFile& file) {
    if (has_facets(file.text)) return false;
    std::string_view text = file.first;
    while (text.starts_with('#') || text.starts_with('\n') || text.starts_with('\r'))
        text.remove_prefix(std::min(text.find_first_of('\n'), text.size() - 1) + 1);
    for (const char* word : {"v ", "vn ", "vt ", "o ", "g ", "mtllib ", "usemtl ", "s "})
        if (text.starts_with(word)) return true;
    return false;
}
bool is_stl(const MeshFile& file) { return has_facets(file.text) || file.ending == ".stl"; }
bool is_ply(const MeshFile& file) { return file.first.starts_with("ply"); }
bool is_off(const MeshFile& file) { return file.first.substr(0, 6).find("OFF") != std::string_view::npos; }

RawMesh read_obj(const MeshFile& file) { return read_surface(file.path, file.text, SurfaceKind::kObj); }
RawMesh read_stl(const MeshFile& file) { return read_surface(file.path, file.text, SurfaceKind::kStl); }
RawMesh read_ply(const MeshFile& file) { return read_surface(file.path, file.text, SurfaceKind::kPly); }
RawMesh read_off(const MeshFile& file) { return read_surface(file.path, file.text, SurfaceKind::kOff); }

}  // namespace haptable
