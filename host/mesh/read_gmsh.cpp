// SPDX-License-Identifier: GPL-2.0-or-later
// Gmsh's library reads many formats, and trusts each of them: damaged files make it crash or take all memory. So counts
// are compared with the file's size first, and the library works in a process of its own with bounded memory and time.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/mesh/in_child.hpp"
#include "host/mesh/modules.hpp"
#include "host/mesh/pack.hpp"
#include "host/mesh/readers.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

constexpr int kTriangle = 2, kTetrahedron = 4, kTriangle6 = 9, kTetrahedron10 = 11;  // Gmsh's numbers of the elements
constexpr std::array<std::size_t, 6> kMiddlesOfGmsh{0, 1, 2, 3, 5, 4};               // between 01 12 20 03 23 13
// Gmsh's tables take about 300 bytes a node, which takes 20 bytes or more in the file.
constexpr std::size_t kGmshLeast_bytes = std::size_t{768} << 20;
constexpr std::size_t kGmshPerByte = 60;
constexpr unsigned kGmshCpu_s = 60;
constexpr double kFarthestCoordinate = 1e30;  // a coordinate beyond is damage

std::size_t line_of(std::string_view text, std::size_t at) {
    return 1 + static_cast<std::size_t>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
}

/// A number at the beginning of `text`, blanks skipped; `text` moves behind it.
std::int64_t number(const fs::path& file, const char* what, std::string_view& text) {
    text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
    std::int64_t value = 0;
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failed != std::errc() || (end != text.data() + text.size() && std::strchr(" \t\r\n", *end) == nullptr))
        fail(file, fmt::format("{} is missing or not a whole number; save the mesh again", what));
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    return value;
}

void require_room(const fs::path& file, std::string_view text, const char* what, std::int64_t count, std::size_t each,
                  const char* rest_from) {
    const auto left = text.size() - static_cast<std::size_t>(rest_from - text.data());
    if (count < 0) fail(file, fmt::format("{}: the count {} is negative; the file is damaged", what, count));
    if (static_cast<std::uint64_t>(count) > left / each + 1)
        fail(file, fmt::format("{} promises {} records (at least {} bytes), and from byte {} the file holds {}: it is "
                               "damaged or cut off",
                               what, count, static_cast<double>(count) * static_cast<double>(each), text.size() - left,
                               left));
}

struct Section {
    const char* name;
    const char* end;
    std::size_t text_bytes;    // of the shortest record as text
    std::size_t binary_bytes;  // and in the binary format
};
constexpr Section kSections[] = {{"$Nodes", "$EndNodes", 6, 24},
                                 {"$Elements", "$EndElements", 4, 8},
                                 {"$NOD", "$ENDNOD", 8, 8},
                                 {"$ELM", "$ENDELM", 8, 8}};

/// Before version 4, text has a line a record: a missing count would make the first record be one.
void require_lines(const fs::path& file, const Section& section, std::string_view rest, int version, bool binary,
                   std::int64_t count) {
    if (version >= 4 || binary) return;
    const std::string_view records = rest.substr(0, rest.find(section.end));
    const std::int64_t lines = std::count(records.begin(), records.end(), '\n') - 1;
    if (lines < count)
        fail(file, fmt::format("{} promises {} records and has {} lines: it is damaged or cut off", section.name, count,
                               lines));
    if (records.find_first_not_of(" \t\r") != records.find('\n'))
        fail(file, fmt::format("{}: the count of records is missing; save the mesh again", section.name));
}

/// Records of version 2: an int and three doubles each, as this machine writes them.
void require_plausible_nodes(const fs::path& file, std::string_view rest, std::int64_t count) {
    rest.remove_prefix(std::min(rest.find('\n') + 1, rest.size()));
    constexpr std::size_t kBytes = sizeof(std::int32_t) + 3 * sizeof(double);
    for (std::size_t k = 0; k < static_cast<std::size_t>(count) && (k + 1) * kBytes <= rest.size(); ++k) {
        std::int32_t tag = 0;
        std::array<double, 3> x{};
        std::memcpy(&tag, rest.data() + k * kBytes, sizeof tag);
        std::memcpy(x.data(), rest.data() + k * kBytes + sizeof tag, sizeof x);
        if (tag <= 0 || !std::all_of(x.begin(), x.end(), [](double c) { return std::abs(c) < kFarthestCoordinate; }))
            fail(file, fmt::format("$Nodes: record {} (number {}, at {:.4g} {:.4g} {:.4g}) is no node; the file is "
                                   "damaged or of another byte order",
                                   k + 1, tag, x[0], x[1], x[2]));
    }
}

/// The count of records that a section promises; 0 where there is no such section.
std::size_t check_section(const fs::path& file, std::string_view text, const Section& section, int version,
                          bool binary) {
    const std::string mark = fmt::format("{}\n", section.name);
    const std::size_t at = text.find(mark);
    if (at == std::string_view::npos) return 0;
    std::string_view rest = text.substr(at + mark.size());
    const std::size_t end = rest.find(section.end);
    if (end == std::string_view::npos && !binary)
        fail(file, fmt::format("{} has no {}: it is cut off; save the mesh again", section.name, section.end));
    std::int64_t count = 0;
    if (version >= 4 && binary) {
        if (rest.size() >= 16) std::memcpy(&count, rest.data() + 8, sizeof count);
    } else {
        if (version >= 4) {
            const std::int64_t blocks = number(file, section.name, rest);
            require_room(file, text, section.name, blocks, 8, rest.data());
        }
        count = number(file, section.name, rest);
    }
    require_room(file, text, section.name, count, binary ? section.binary_bytes : section.text_bytes, rest.data());
    require_lines(file, section, rest.substr(0, end), version, binary, count);
    if (binary && version == 2 && section.name == kSections[0].name) require_plausible_nodes(file, rest, count);
    return static_cast<std::size_t>(count);
}

/// Returns how many elements the file promises.
std::size_t check_msh(const fs::path& file, std::string_view text) {
    const std::size_t format = text.find("$MeshFormat\n");
    int version = 1;
    bool binary = false;
    if (format != std::string_view::npos) {
        std::string_view rest = text.substr(format + 12);
        version = rest.empty() ? 0 : rest[0] - '0';
        binary = rest.find(" 1 ") < rest.find('\n');
    }
    if (!binary) refuse_comma_decimals(file, text);
    std::size_t elements = 0;
    for (const Section& section : kSections) {
        const std::size_t count = check_section(file, text, section, version, binary);
        if (section.name[1] == 'E') elements = std::max(elements, count);
    }
    return elements;
}

void check_vtk(const fs::path& file, std::string_view text) {
    const std::size_t set = text.find("\nDATASET ");
    if (set != std::string_view::npos && text.substr(set + 9, 17) != "UNSTRUCTURED_GRID")
        fail(file, fmt::format("is VTK of DATASET {}, not UNSTRUCTURED_GRID: give a volume mesh",
                               text.substr(set + 9, text.find_first_of(" \r\n", set + 9) - set - 9)));
    if (text.find("\nOFFSETS ") != std::string_view::npos)
        fail(file, "is VTK of version 5, whose cells have OFFSETS: save it as .vtu, or as legacy VTK 4.2");
    const bool binary = text.substr(0, 1024).find("\nBINARY") != std::string_view::npos;
    if (!binary) refuse_comma_decimals(file, text);
    for (const auto& [word, each] :
         {std::pair("\nPOINTS ", 6U), std::pair("\nCELLS ", 4U), std::pair("\nCELL_TYPES ", 2U)}) {
        const std::size_t at = text.find(word);
        if (at == std::string_view::npos) continue;
        std::string_view rest = text.substr(at + std::strlen(word));
        const std::int64_t count = number(file, word + 1, rest);
        require_room(file, text, word + 1, count, each, rest.data());
    }
}

/// A folder of its own with the file under a name that makes Gmsh choose the reader which its content asks for.
class Staged {
public:
    Staged(const fs::path& file, std::string_view text, std::string_view kind, bool copy) {
        std::string pattern = (fs::temp_directory_path() / "haptable-XXXXXX").string();
        if (mkdtemp(pattern.data()) == nullptr) fail(file, "no temporary folder can be made; is the disk full?");
        folder_ = pattern;
        path_ = folder_ / ("mesh" + std::string(kind));
        if (copy)
            write_file(path_, text);
        else
            fs::create_symlink(fs::absolute(file), path_);
    }
    ~Staged() {
        std::error_code ignored;
        fs::remove_all(folder_, ignored);
    }
    Staged(const Staged&) = delete;
    Staged& operator=(const Staged&) = delete;
    std::string path() const { return path_.string(); }

private:
    fs::path folder_, path_;
};

/// Line ends as Gmsh reads them: LF.
std::string unix_lines(std::string_view text) {
    std::string plain;
    plain.reserve(text.size());
    for (std::size_t k = 0; k < text.size(); ++k) {
        if (text[k] == '\r' && k + 1 < text.size() && text[k + 1] == '\n') continue;
        plain.push_back(text[k] == '\r' ? '\n' : text[k]);
    }
    return plain;
}

struct Elements {
    int type = 0, dimension = 0;
    std::string name;
    std::size_t nodes = 1;
    std::vector<Tag> tag, node;
    std::vector<Tag> nodes_of(std::size_t k) const {
        const auto first = node.begin() + static_cast<std::ptrdiff_t>(k * nodes);
        return {first, first + static_cast<std::ptrdiff_t>(nodes)};
    }
};

std::vector<Elements> unpack_elements(Unpacker& in) {
    std::vector<Elements> all(in.one<std::size_t>());
    for (Elements& elements : all) {
        elements.type = in.one<int>();
        elements.name = in.text();
        elements.dimension = in.one<int>();
        elements.nodes = static_cast<std::size_t>(in.one<int>());
        elements.tag = in.list<Tag>();
        elements.node = in.list<Tag>();
    }
    return all;
}

void add_elements(const Elements& elements, RawMesh& raw) {
    for (std::size_t k = 0; k < elements.tag.size(); ++k) {
        const std::vector<Tag> node = elements.nodes_of(k);
        if (elements.type == kTetrahedron || elements.type == kTetrahedron10)
            raw.add_tet(elements.tag[k], node, kMiddlesOfGmsh);
        else if (elements.dimension == 3)
            raw.add_other(elements.name, elements.tag[k]);
        else if (elements.dimension == 2)
            ++raw.surface_elements;
        if (elements.type == kTriangle) raw.triangle.push_back({node[0], node[1], node[2]});
    }
}

/// Tetrahedra of a group are found again by their nodes: numbers of elements may repeat in a file.
using TetPlaces = std::vector<std::pair<std::array<Tag, 4>, std::size_t>>;

void add_group(const Elements& elements, const TetPlaces& places, RawGroup& group) {
    for (std::size_t k = 0; k < elements.tag.size(); ++k) {
        const std::vector<Tag> node = elements.nodes_of(k);
        group.node.insert(group.node.end(), node.begin(), node.end());
        if (elements.type == kTriangle || elements.type == kTriangle6)
            group.triangle.push_back({node[0], node[1], node[2]});
        if (elements.dimension != 3 || node.size() < 4) continue;
        const std::array<Tag, 4> key{node[0], node[1], node[2], node[3]};
        const auto at = std::lower_bound(places.begin(), places.end(), std::pair(key, std::size_t{0}));
        if (at != places.end() && at->first == key) group.tet.push_back(at->second);
    }
}

/// Gmsh drops elements whose numbers repeat, in silence: `promised` of them must have come.
RawMesh unpack_model(const fs::path& file, std::string_view bytes, std::size_t promised) {
    static_assert(sizeof(Tag) == sizeof(std::size_t));
    Unpacker in(bytes);
    RawMesh raw;
    raw.node_tag = in.list<Tag>();
    const auto coordinate = in.list<double>();
    for (std::size_t k = 0; k + 2 < coordinate.size(); k += 3)
        raw.position.emplace_back(coordinate[k], coordinate[k + 1], coordinate[k + 2]);
    for (std::size_t count = in.one<std::size_t>(); count > 0; --count) {
        raw.notes.push_back("Gmsh: " + in.text());
    }
    std::size_t taken = 0;
    for (const Elements& elements : unpack_elements(in)) {
        add_elements(elements, raw);
        taken += elements.tag.size();
    }
    if (taken < promised)
        fail(file,
             fmt::format("promises {} elements and {} of them can be told apart: numbers of elements repeat, or the "
                         "count is wrong; save the mesh again",
                         promised, taken));
    TetPlaces places;
    for (std::size_t t = 0; t < raw.tet.size(); ++t) places.emplace_back(raw.tet[t], t);
    std::sort(places.begin(), places.end());
    for (std::size_t groups = in.one<std::size_t>(); groups > 0; --groups) {
        RawGroup& group = raw.group[in.text()];
        for (std::size_t entities = in.one<std::size_t>(); entities > 0; --entities)
            for (const Elements& elements : unpack_elements(in)) add_group(elements, places, group);
    }
    return raw;
}

/// Through the Gmsh library, in a process of its own: it may crash, hang or take all memory without harm.
/// kind: the name that makes the library choose the reader that we mean: ".msh", ".vtk", ".mesh".
RawMesh read_with_gmsh(const fs::path& file, std::string_view given, std::string_view kind) {
    const bool binary = given.find('\0') != std::string_view::npos;
    const std::string plain = !binary && given.find('\r') != std::string_view::npos ? unix_lines(given) : std::string();
    const std::string_view text = plain.empty() ? given : std::string_view(plain);
    const std::size_t promised = kind == ".msh" ? check_msh(file, text) : 0;
    if (kind == ".vtk") check_vtk(file, text);
    if (kind == ".mesh") refuse_comma_decimals(file, text);
    const bool is_as_given = plain.empty() && fs::file_size(file) == text.size();  // without UTF-8's mark
    const Staged staged(file, text, kind, !is_as_given);
    const ChildLimits limits{kGmshLeast_bytes + kGmshPerByte * text.size(),
                             kGmshCpu_s + static_cast<unsigned>(text.size() >> 20)};
    const auto read = from_module<decltype(haptable_gmsh_read)>(file, "haptable-gmsh", "haptable_gmsh_read");
    const std::string bytes = run_in_child(file.string(), limits, [&] {
        std::string packed;
        read(file, staged.path(), packed);
        return packed;
    });
    return unpack_model(file, bytes, promised);
}

}  // namespace

void refuse_comma_decimals(const fs::path& file, std::string_view text) {
    const auto digit = [](char c) { return c >= '0' && c <= '9'; };
    std::size_t begin = 0;
    for (int title = 0; title < 2 && begin != std::string_view::npos; ++title) begin = text.find('\n', begin + 1);
    for (std::size_t at = text.find(',', begin); at != std::string_view::npos; at = text.find(',', at + 1)) {
        if (at == 0 || at + 1 >= text.size() || !digit(text[at - 1]) || !digit(text[at + 1])) continue;
        const std::size_t line = text.rfind('\n', at) + 1;
        if (text.substr(line, at - line).find('"') != std::string_view::npos) continue;  // a name
        const std::size_t first = text.find_last_of(" \t\n", at) + 1;
        fail(file, fmt::format("line {}: \"{}\" is not a number: decimals need a point", line_of(text, at),
                               text.substr(first, std::min<std::size_t>(40, text.find_first_of(" \t\n", at) - first))));
    }
}

bool is_gmsh(const MeshFile& file) {
    return file.first.starts_with("$MeshFormat") || file.first.starts_with("$NOD") ||
           file.first.starts_with("$Comments");
}
bool is_vtk(const MeshFile& file) { return file.first.starts_with("# vtk"); }
bool is_medit(const MeshFile& file) { return file.head.find("MeshVersionFormatted") != std::string_view::npos; }

RawMesh read_gmsh(const MeshFile& file) { return read_with_gmsh(file.path, file.text, ".msh"); }
RawMesh read_vtk(const MeshFile& file) {
    RawMesh raw = read_with_gmsh(file.path, file.text, ".vtk");
    raw.vectors = read_vtk_vectors(file.path, file.text, file.vectors);
    return raw;
}
RawMesh read_medit(const MeshFile& file) { return read_with_gmsh(file.path, file.text, ".mesh"); }

}  // namespace haptable
