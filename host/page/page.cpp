// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/page/page.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "codegen/loaded_scene.hpp"
#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/installed.hpp"
#include "host/base/json.hpp"
#include "host/base/program.hpp"
#include "host/page/base64.hpp"
#include "host/page/columns.hpp"
#include "host/page/modes.hpp"
#include "host/page/pointer_device.hpp"
#include "host/view/colormap.hpp"
#include "host/view/surface.hpp"

namespace haptable {

namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr double kBase64 = 4.0 / 3.0;

/// The binary tables of a page in a row, each at a multiple of 16 bytes, and what tells them apart.
class Blob {
public:
    void add(const std::string& name, std::string_view bytes) {
        bytes_.resize((bytes_.size() + 15) / 16 * 16, '\0');
        tables_[name] = {{"offset", bytes_.size()}, {"bytes", bytes.size()}};
        bytes_ += bytes;
    }
    template <typename Row>
    void add_rows(const std::string& name, const std::vector<Row>& rows) {
        add(name, {reinterpret_cast<const char*>(rows.data()), rows.size() * sizeof(Row)});
    }
    const json& tables() const { return tables_; }
    const std::string& bytes() const { return bytes_; }

private:
    json tables_ = json::object();
    std::string bytes_;
};

std::uint32_t crc_of(const std::string& bytes) {
    return static_cast<std::uint32_t>(
        crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<z_size_t>(bytes.size())));
}

/// Rest shape, patches and their marks.
void add_surface(const Tables& tables, const PageRows& rows, Blob& blob, json& scene) {
    const DrawnSurface surface(tables);
    std::vector<std::int32_t> place(tables.position.size(), -1), row;
    for (std::size_t r = 0; r < rows.node.size(); ++r)
        place[static_cast<std::size_t>(rows.node[r])] = static_cast<std::int32_t>(r);
    for (const std::int32_t node : surface.node_id) row.push_back(place[static_cast<std::size_t>(node)]);
    std::vector<std::uint8_t> mark;  // 1 touchable, 2 held still, 4 << c crease opposite to corner c
    for (std::size_t p = 0; p < surface.patches(); ++p) {
        const auto held = [&](int c) { return surface.row[static_cast<std::size_t>(surface.patch[p][c])] < 0; };
        const bool fixed = !tables.row_id.empty() && held(0) && held(1) && held(2);
        unsigned bits = (surface.touchable[p] != 0 ? 1U : 0U) | (fixed ? 2U : 0U);
        for (std::size_t c = 0; c < 3; ++c) bits |= surface.crease[p][c] != 0 ? 4U << c : 0U;
        mark.push_back(static_cast<std::uint8_t>(bits));
    }
    blob.add_rows("rest", surface.rest_m);
    blob.add_rows("row", row);
    blob.add_rows("surface_node", surface.node_id);
    blob.add_rows("patch", surface.patch);
    blob.add_rows("normal_of", surface.normal_of);
    blob.add_rows("mark", mark);
    scene["surface"] = {{"nodes", surface.nodes()}, {"patches", surface.patches()}, {"normals", surface.normal.size()}};
}

void add_modes(const std::vector<PageMode>& modes, Blob& blob, json& scene) {
#define HAPTABLE_FORCE_LAW(NAME, WORD, TITLE, ...) scene["titles"][WORD] = TITLE;
#define HAPTABLE_GOD_OBJECT(NAME, WORD, TITLE, ...) scene["titles"][WORD] = TITLE;
#include "host/base/laws.inc"
    for (std::size_t i = 0; i < modes.size(); ++i) {
        const std::string table = fmt::format("model {}", i);
        blob.add(table, modes[i].model);
        // Models of one force share their bytes.
        const auto share = [&](const char* what, const std::string& bytes) {
            std::string name = bytes.empty() ? "" : fmt::format("{} {}", what, word(modes[i].force));
            if (!bytes.empty() && !blob.tables().contains(name)) blob.add(name, bytes);
            return name;
        };
        scene["modes"].push_back({{"force", word(modes[i].force)},
                                  {"god_object", word(modes[i].god_object)},
                                  {"friction", modes[i].friction},
                                  {"hash", fmt::format("{:016x}", modes[i].hash)},
                                  {"model", table},
                                  {"coupling", share("coupling", modes[i].coupling)},
                                  {"tool", share("tool", modes[i].tool)},
                                  {"body_modes", share("body_modes", modes[i].body_modes)}});
    }
}

/// Adds a body that nothing holds: what moves it, and for the picture where it rests.
void add_body(const haptable_body& body, Blob& blob, json& scene) {
    blob.add("body", {reinterpret_cast<const char*>(&body), sizeof body});
    scene["body"] = {{"rest_centre", body.centre_m}};
    if (body.point_count > 0) scene["body"]["floor"] = {{"normal", body.floor_normal}, {"height", body.floor_m}};
}

/// Adds the tool that the hand holds: where its points are, and how it looks.
void add_tool(const ToolTables& tool, Blob& blob, json& scene) {
    scene["tool"] = {{"point_m", tool.point_m}};
    blob.add_rows("tool_surface", tool.surface_corner_m);
}

/// Adds the modes of a body that rings: phi of each of the page's rows, [r, m].
void add_modes(const SceneFiles& files, const PageRows& rows, Blob& blob, json& scene) {
    const ModeTables& body_modes = *files.body_modes;
    const std::size_t modes = body_modes.modes();
    if (body_modes.row.size() != modes * files.tables.row_id.size())
        files.folder.fail("mode_rows.npy", "does not fit row_id.npy");
    std::vector<std::array<float, 3>> phi;
    for (const std::size_t row : stored_rows(files.tables, rows))
        phi.insert(phi.end(), body_modes.row.begin() + static_cast<std::ptrdiff_t>(row * modes),
                   body_modes.row.begin() + static_cast<std::ptrdiff_t>((row + 1) * modes));
    blob.add_rows("mode_rows", phi);
    scene["body_modes"] = {{"modes", modes}};
}

/// How the mask spreads a load: over columns instead of mesh nodes.
void add_spread(const Tables& tables, const ServoModel& servo, Blob& blob) {
    const ComplianceTables& c = tables.compliance;
    std::vector<std::int32_t> vertex, edge, column(tables.position.size(), -1), spread;
    for (const std::int32_t node : servo.node) {
        const auto at = std::lower_bound(c.vertex_id.begin(), c.vertex_id.end(), node);
        vertex.push_back(static_cast<std::int32_t>(at - c.vertex_id.begin()));
    }
    for (const auto& edges : servo.compliance.patch_edge)
        for (const std::uint16_t e : edges) edge.push_back(static_cast<std::int32_t>(c.vertex_id.size()) + e);
    for (std::size_t i = 0; i < tables.node_id.size(); ++i)
        column[static_cast<std::size_t>(tables.node_id[i])] = static_cast<std::int32_t>(i);
    for (const std::int32_t node : c.spread_node) spread.push_back(column[static_cast<std::size_t>(node)]);
    blob.add_rows("vertex_control", vertex);
    blob.add_rows("edge_control", edge);
    blob.add_rows("spread_begin", c.spread_begin);
    blob.add_rows("spread_column", spread);
    blob.add_rows("spread_weight", c.spread_weight);
}

json hand_of(const Device& device) {
    return {{"mass_kg", device.mass_kg[0]},
            {"damping_n_s_per_m", device.damping_n_s_per_m},
            {"friction_n", device.friction_n},
            {"max_force_n", device.max_force_n},
            {"encoder_step_m", device.encoder_step_m},
            {"stiffness_n_per_m", Hand{}.stiffness_n_per_m},
            {"hand_damping_n_s_per_m", Hand{}.damping_n_s_per_m}};
}

/// Custom properties of CSS: what things are drawn in, on the page's light ground and on its dark one.
std::string drawn_colors() {
    std::string light, dark;
    for (const DrawnColor& color : kDrawnColors) {
        std::string name(color.name);
        std::replace(name.begin(), name.end(), '_', '-');
        light += fmt::format("--{}: #{:06x}; ", name, color.on_light);
        dark += fmt::format("--{}: #{:06x}; ", name, color.on_dark);
    }
    return fmt::format(":root {{ {}}} :root.dark {{ {}}}", light, dark);
}

std::string colors() {
    std::string text;
    for (const Rgb8& color : color_map()) text += fmt::format("{:02x}{:02x}{:02x}", color[0], color[1], color[2]);
    return text;
}

/// S of a typical node: the median of the mean of its eigenvalues, N/m.
double typical_stiffness(const Tables& tables) {
    std::vector<double> mean;
    for (const auto& s : tables.stiffness) mean.push_back((s[0] + s[4] + s[8]) / 3.0);
    if (mean.empty()) return tables.rigid_stiffness_n_per_m;
    const auto middle = mean.begin() + static_cast<std::ptrdiff_t>(mean.size() / 2);
    std::nth_element(mean.begin(), middle, mean.end());
    return *middle;
}

json describe(const Tables& tables, const TablesFolder& folder, const ServoModel& servo) {
    const json& facts = folder.facts();
    json scene{{"name", tables.name},
               {"scene", tables.scene_file},
               {"version", kVersion},
               {"colors", colors()},
               {"node", servo.node},
               {"free", servo.free_count},
               {"workspace", {{"origin_m", servo.grid_origin_m}, {"limit_m", servo.workspace_limit_m}}},
               {"hand", hand_of(pointer_device(tables, folder))},
               {"stiffness_n_per_m", typical_stiffness(tables)}};
    for (const char* key : {"material", "counts", "small_strain", "element"})
        if (facts.contains(key)) scene[key] = facts[key];
    return scene;
}

/// Text that stands inside of an element of HTML and cannot end it.
std::string inert(std::string text) {
    for (std::size_t at = 0; (at = text.find("</", at)) != std::string::npos; at += 3) text.replace(at, 2, "<\\/");
    return text;
}

std::string replaced(const std::string& text, const std::map<std::string, std::string>& values) {
    std::string out;
    std::size_t done = 0;
    for (std::size_t at = 0; (at = text.find("{{", done)) != std::string::npos;) {
        const std::size_t end = text.find("}}", at);
        const auto value = values.find(text.substr(at + 2, end - at - 2));
        if (end == std::string::npos || value == values.end()) throw Error("page.html names what there is not");
        out.append(text, done, at - done).append(value->second);
        done = end + 2;
    }
    return out + text.substr(done);
}

/// Without columns a page would show a body that nothing moves.
void require_columns(const Tables& tables, const TablesFolder& folder) {
    if (tables.has_columns) return;
    throw Error(fmt::format(
        "{}: has no columns.npy, by which a page deforms the body: {}, and make the tables again", folder.text(),
        tables.has_factor ? "raise tables.column_budget in the scene" : "leave out tables.columns = \"none\""));
}

}  // namespace

fs::path page_parts() {
    const fs::path found = find_part("page");
    fs::path parts = found.empty() ? program_folder().parent_path() / "lib/page" : found;
    for (const char* file : {"servo.wasm", "three.min.js", "page.html"})
        if (!fs::exists(parts / file))
            throw Error(
                fmt::format("{}: is not there, and a page is made of it: run make touch", (parts / file).string()));
    return parts;
}

Device pointer_device(const Tables& tables, const TablesFolder& folder) {
    Device device;
    const std::vector<double> mass_kg = folder.options().numbers("device.mass");
    device.mass_kg.fill((mass_kg.at(0) + mass_kg.at(1) + mass_kg.at(2)) / 3.0);
    device.max_force_n = tables.max_force_n;
    device.damping_n_s_per_m = tables.damping_n_s_per_m;
    device.friction_n = tables.device_friction_n;
    device.encoder_step_m = tables.encoder_step_m;
    return device;
}

PageReport write_page(const TablesFolder& folder, const fs::path& parts, const fs::path& out, double most_bytes) {
    const PageText page = make_page(folder, parts, most_bytes);
    write_file(out, page.html);
    return page.report;
}

PageText make_page(const TablesFolder& folder, const fs::path& parts, double most_bytes, const std::string& live) {
    const SceneFiles files = read_scene_files(folder);
    const LoadedScene own(files);
    own.require_tables_hash(folder.tables_hash());
    const Tables& tables = own.tables();
    require_columns(tables, folder);
    const ServoModel& servo = own.servo();
    const PageRows rows = page_rows(tables);
    std::vector<PageMode> modes = page_modes(files);
    const bool has_tool = files.tool && live.empty();  // of a session elsewhere the hand's contact is shown
    if (!live.empty()) modes.resize(1);
    if (!has_tool && files.tool) modes[0].coupling = modes[0].tool = "";
    json scene = describe(tables, folder, servo);
    scene["live"] = !live.empty();
    scene["fingers"] = own.pair() == nullptr ? 1 : 2;
    Blob blob;
    add_surface(tables, rows, blob, scene);
    add_modes(modes, blob, scene);
    if (has_tool) add_tool(*files.tool, blob, scene);
    if (files.body) add_body(*files.body, blob, scene);
    if (files.body_modes) add_modes(files, rows, blob, scene);
    if (tables.force == ForceLaw::kPressureMask) add_spread(tables, servo, blob);

    std::map<std::string, std::string> text;
    for (const char* file :
         {"page.css", "engine.js", "text.js", "data.js", "picture.js", "plot.js", "live.js", "page.js", "three.min.js"})
        text[file] = read_file(parts / file);
    text["wasm"] = to_base64(read_file(parts / "servo.wasm"));
    const std::string page_html = read_file(parts / "page.html");
    double others = kBase64 * static_cast<double>(blob.bytes().size()) +
                    static_cast<double>(page_html.size() + json_text(scene).size());
    for (const auto& [name, value] : text) others += static_cast<double>(value.size());
    const auto with = [&](std::size_t bytes) {
        return others + kBase64 * static_cast<double>(bytes * packed_count(rows));
    };
    const bool single = !tables.half_columns && with(sizeof(float)) <= most_bytes;
    if (!single && with(2) > most_bytes)
        throw Error(
            fmt::format("the page would be {:.1f} MB, its columns in float16, and {:.1f} MB is the most: give "
                        "--megabytes {:.0f}, or a coarser mesh",
                        1e-6 * with(2), 1e-6 * most_bytes, std::ceil(1e-6 * with(2)) + 1.0));
    const PageColumns columns = pack_columns(tables, folder, rows, single ? Storage::kFloat32 : Storage::kFloat16);
    blob.add("columns", columns.bytes);
    scene["columns"] = {{"format", word(columns.format)},
                        {"columns", rows.columns},
                        {"rows", rows.node.size()},
                        {"unit_m_per_n", columns.unit_m_per_n},
                        {"error", columns.error}};
    scene["tables"] = blob.tables();
    scene["bytes"] = blob.bytes().size();
    scene["crc32"] = crc_of(blob.bytes());
    text["drawn_colors"] = drawn_colors();
    text["connect"] = live.empty() ? "" : "; connect-src " + live;
    text["name"] = tables.name;
    text["scene"] = inert(json_text(scene));
    text["data"] = to_base64(blob.bytes());
    PageText page{replaced(page_html, text), {0, {}, word(columns.format), columns.error}};
    page.report.bytes = page.html.size();
    for (const PageMode& mode : modes)
        page.report.modes.push_back(
            fmt::format("{} {}{}", word(mode.force), word(mode.god_object), mode.friction > 0.0 ? " friction" : ""));
    return page;
}

}  // namespace haptable
