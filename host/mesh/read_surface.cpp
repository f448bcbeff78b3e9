// SPDX-License-Identifier: GPL-2.0-or-later
// STL, OBJ, PLY and OFF by CGAL's readers, in a process of their own as every reader that we did not write.
#include <fmt/format.h>

#include <cstring>

#include "host/base/error.hpp"
#include "host/mesh/in_child.hpp"
#include "host/mesh/modules.hpp"
#include "host/mesh/pack.hpp"
#include "host/mesh/readers.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLeastMemory_bytes = std::size_t{512} << 20;
constexpr std::size_t kMemoryPerByte = 40;
constexpr unsigned kCpu_s = 60;

[[noreturn]] void fail(const fs::path& file, const std::string& what) { throw Error(file.string() + ": " + what); }

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

}  // namespace

RawMesh read_surface(const fs::path& file, std::string_view text, SurfaceKind kind) {
    if (kind == SurfaceKind::kStl) check_stl(file, text);
    const ChildLimits limits{kLeastMemory_bytes + kMemoryPerByte * text.size(),
                             kCpu_s + static_cast<unsigned>(text.size() >> 20)};
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

}  // namespace haptable
