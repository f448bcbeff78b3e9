// SPDX-License-Identifier: GPL-2.0-or-later
// The C text of a model: const tables by field name, no clock, no path.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <concepts>
#include <ranges>
#include <string_view>
#include <type_traits>

#include "codegen/body_modes.hpp"
#include "codegen/codegen.hpp"
#include "codegen/display.hpp"
#include "codegen/in_memory.hpp"
#include "codegen/loaded_scene.hpp"
#include "codegen/number.hpp"
#include "codegen/pair.hpp"
#include "codegen/precision.hpp"
#include "codegen/rigid_body.hpp"
#include "codegen/scene_bytes.hpp"
#include "codegen/template.hpp"
#include "codegen/tool.hpp"
#include "firmware/haptable.h"
#include "firmware/haptable_model.h"
#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/program.hpp"
#include "host/base/text.hpp"

namespace haptable {

namespace {

// Each begins with a line's end.
constexpr const char* kHeaderText =
#include "codegen/model.h.in"
    ;
constexpr const char* kSourceText =
#include "codegen/model.c.in"
    ;

using haptable::literal;
std::string literal(std::integral auto value) { return fmt::format("{}", value); }
std::string literal(const std::ranges::range auto& values) {
    std::string text = "{";
    for (const auto value : values) text += (text.size() == 1 ? "" : ", ") + literal(value);
    return text + "}";
}
std::string literal(const haptable_box& box) {
    return fmt::format("{{{}, {}, {}, {}}}", literal(box.low), literal(box.high), box.skip, box.patch);
}
std::string literal(const haptable_hinge& hinge) {
    return fmt::format("{{{}, {}, {}}}", hinge.vertex, hinge.patch, hinge.ring);
}

/// The type of a row in C.
constexpr const char* type_of(float) { return "float"; }
constexpr const char* type_of(std::uint16_t) { return "uint16_t"; }
constexpr const char* type_of(const haptable_box&) { return "struct haptable_box"; }
constexpr const char* type_of(const haptable_hinge&) { return "struct haptable_hinge"; }
template <typename Number, std::size_t k>
constexpr const char* type_of(const std::array<Number, k>&) {
    return type_of(Number());
}

/// What of it stands behind the table's name.
template <typename Row>
std::string extent_of(const Row&) {
    return "";
}
template <typename Number, std::size_t k>
std::string extent_of(const std::array<Number, k>&) {
    return fmt::format("[{}]", k);
}

std::string nodes(const std::vector<std::int32_t>& values) {
    std::string text;
    for (std::int32_t node : values) text += fmt::format("    {},\n", node);
    return text;
}

/// The scene's name as part of a C identifier.
std::string identifier(const std::string& name) {
    std::string text = name;
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
    return text;
}

/// The macro of model.h for a number of rows; empty where it has none.
std::string macro_of(std::string_view count, const std::string& macro) {
    constexpr std::pair<std::string_view, const char*> kMacros[] = {{"vertex_count", "_VERTICES"},
                                                                    {"free_count", "_FREE_VERTICES"},
                                                                    {"patch_count", "_PATCHES"},
                                                                    {"box_count", "_BOXES"}};
    for (const auto& [name, ending] : kMacros)
        if (name == count) return macro + ending;
    return "";
}

/// What a compliance's table is called in model.c, where the model's own stand beside it.
std::string compliance_name(const std::string& name) {
    return name == "patch_edge" ? name : name + "_compliance_m_per_n";
}

#define HAPTABLE_PASS(...)
#define HAPTABLE_VISIT(type, name, count) visit_written(#name, #count, model.name);
#define HAPTABLE_VISIT_COMPLIANCE(type, name, count) \
    visit_written(compliance_name(#name), #count, model.compliance.name);

/// visit(name, count as text, rows) for every table that the model's modes need, in the order of the file.
template <typename Visit>
void each_table(const ServoModel& model, Visit visit) {
    const auto visit_written = [&](const std::string& name, const char* count, const auto& rows) {
        const bool is_block = name == "stiffness_n_per_m" || name.ends_with("_compliance_m_per_n");
        const bool is_read = name == "stiffness_n_per_m" ? model.reads_stiffness() : model.reads_compliance();
        if (!rows.empty() && (!is_block || is_read)) visit(name, count, rows);
    };
    HAPTABLE_MODEL_FIELDS(HAPTABLE_PASS, HAPTABLE_VISIT, HAPTABLE_PASS, HAPTABLE_PASS)
    HAPTABLE_COMPLIANCE_FIELDS(HAPTABLE_PASS, HAPTABLE_VISIT_COMPLIANCE)
}

std::string definitions(const ServoModel& model, const std::string& macro) {
    std::string text;
    each_table(model, [&](const std::string& name, const char* count, const auto& rows) {
        const std::string rows_macro = macro_of(count, macro);
        text += fmt::format("static const {} {}[{}]{} = {{\n", type_of(rows[0]), name,
                            rows_macro.empty() ? std::to_string(rows.size()) : rows_macro, extent_of(rows[0]));
        for (const auto& row : rows) text += "    " + literal(row) + ",\n";
        text += "};\n\n";
    });
    return text;
}

/// The fields of a struct by name, in its order; what is 0 or NULL is left out.
class Initialiser {
public:
    explicit Initialiser(std::string macro) : macro_(std::move(macro)) {}

    void add(const char* name, const std::string& value) { text_ += fmt::format("    .{} = {},\n", name, value); }
    template <typename Value>
    void add_value(const char* name, const Value& value) {
        if constexpr (std::is_arithmetic_v<Value>)
            if (value == Value()) return;
        const std::string in_model_h = macro_of(name, macro_);
        add(name, in_model_h.empty() ? literal(value) : in_model_h);
    }
    template <typename Function>
    void add_function(const char* name, Function* function,
                      std::initializer_list<std::pair<Function*, const char*>> choices) {
        for (const auto& [known, its_name] : choices)
            if (known == function) add(name, its_name);
    }
    const std::string& text() const { return text_; }

private:
    std::string macro_, text_;
};

#define HAPTABLE_PUT_VALUE(type, name) to.add_value(#name, from.name);
#define HAPTABLE_PUT_TABLE(type, name, count) \
    if (from.name != nullptr) to.add(#name, #name);
#define HAPTABLE_PUT_COMPLIANCE_TABLE(type, name, count) \
    if (from.name != nullptr) to.add(#name, compliance_name(#name));
#define HAPTABLE_NAMED(function) {function, #function},
#define HAPTABLE_PUT_FUNCTION(type, name, choices) to.add_function<type>(#name, from.name, {choices(HAPTABLE_NAMED)});
#define HAPTABLE_PUT_PART(type, name) \
    if (from.name != nullptr) to.add(#name, "&" #name);

std::string compliance_fields(const haptable_compliance* compliance) {
    if (compliance == nullptr) return "";
    const haptable_compliance& from = *compliance;
    Initialiser to("");
    HAPTABLE_COMPLIANCE_FIELDS(HAPTABLE_PUT_VALUE, HAPTABLE_PUT_COMPLIANCE_TABLE)
    to.add("span", "haptable_span_of_compliance");
    return to.text();
}

std::string model_fields(const haptable_model& from, const std::string& macro) {
    Initialiser to(macro);
    HAPTABLE_MODEL_FIELDS(HAPTABLE_PUT_VALUE, HAPTABLE_PUT_TABLE, HAPTABLE_PUT_FUNCTION, HAPTABLE_PUT_PART)
    return to.text();
}

std::string sizes(const ServoModel& servo) {
    std::vector<std::string> list;
    for (const TableBytes& table : flash_tables(servo)) list.push_back("sizeof " + table.name);
    return fmt::format("{}", fmt::join(list, " +\n                        "));
}

/// The first member of the servo that a scene of one finger does without; "": it has all.
const char* servo_end(const haptable_model& model) {
    if (model.energy != nullptr) return "";
    if (model.release != nullptr) return "sensitivity_per_m";
    if (model.passivity != nullptr) return "felt_n";
    return model.resume != nullptr ? "given_j" : "nearest_m2";
}

/// Values of the model, and which parts the scene has besides.
TemplateValues values_of(const Tables& tables, const ServoModel& servo, const haptable_model& model,
                         const ServoPair* pair, const ServoModes* body_modes, const haptable_body* body,
                         const haptable_tool_model* tool) {
    const std::string name = "haptable_" + identifier(tables.name), macro = upper(name);
    const auto flag = [](bool is_set) { return is_set ? "yes" : ""; };
    const bool moves = body != nullptr || body_modes != nullptr;
    const int fingers = pair != nullptr && tool == nullptr ? pair->finger_count : 1;
    const bool has_points = tool != nullptr || fingers > HAPTABLE_FINGERS;
    return {{"version", kVersion},
            {"scene_file", tables.scene_file},
            {"scene", tables.name},
            {"name", name},
            {"NAME", macro},
            {"force", word(tables.force)},
            {"god_object", word(tables.god_object)},
            {"precision", word(tables.precision)},
            {"vertices", std::to_string(servo.node.size())},
            {"free_vertices", std::to_string(servo.free_count)},
            {"patches", std::to_string(servo.patch.size())},
            {"boxes", std::to_string(servo.box.size())},
            {"bytes", std::to_string(flash_bytes(servo))},
            {"segment_mm", fmt::format("{:g}", 1e3 * static_cast<double>(HAPTABLE_FAST_SEGMENT_M))},
            {"fast_way_boxes", std::to_string(servo.search.fast_way_boxes)},
            {"tick_boxes", std::to_string(HAPTABLE_TICK_BOXES)},
            {"table_version", std::to_string(HAPTABLE_TABLE_VERSION)},
            {"tables", definitions(servo, macro)},
            {"compliance", compliance_fields(model.compliance)},
            {"sizes", sizes(servo)},
            {"nodes", nodes(servo.node)},
            {"model", model_fields(model, macro)},
            {"hinges", flag(model.hinges != nullptr)},
            {"slivers", model.slivers == nullptr                        ? ""
                        : model.slivers == &haptable_slivers_of_patches ? "patches"
                                                                        : "corners"},
            {"servo_end", pair != nullptr || tool != nullptr ? "" : servo_end(model)},
            {"checked_parts", flag(model.check != nullptr && (moves || pair != nullptr))},
            {"relaxed", flag(model.term_count > 0)},
            {"freed", flag(model.frictionless != nullptr && !has_points)},
            {"fingers", std::to_string(fingers)},
            {"coupled", flag(pair != nullptr)},
            {"finger_pair", flag(fingers > 1)},
            {"pair", flag(fingers > 1 && !has_points)},
            {"tool", flag(tool != nullptr)},
            {"hands", flag(fingers > HAPTABLE_FINGERS)},
            {"points", flag(has_points)},
            {"point_count", std::to_string(fingers)},  // of a tool: add_tool_values
            {"points_state", tool != nullptr ? "hand" : "hands"},
            {"of_line", tool != nullptr ? "tool_"
                        : has_points    ? "hands_"
                                        : ""},
            {"modes", flag(body_modes != nullptr)},
            {"moves", flag(moves)},
            {"step", tool != nullptr              ? "step_tool"
                     : fingers > HAPTABLE_FINGERS ? "step_hands"
                     : !moves                     ? (pair != nullptr ? "step_held" : "step_one")
                     : model.stiffen != nullptr   ? "moving_stiffening"
                                                  : "moving"},
            {"body", body != nullptr ? rigid_body_fields(*body) : ""}};
}

/// The lines of model.h and model.c on what moves under the contacts: the body, by its part, and the modes.
void add_movers(const haptable_body* body, const ServoModes* body_modes, TemplateValues& values) {
    for (const char* lines : {"mover_tables", "mover_parts", "mover_states", "mover_places"}) values[lines] = "";
    const auto add = [&values, &name = values.at("name")](const char* mover, const char* pointer, const char* part) {
        values["mover_tables"] += fmt::format("    .{0} = &{1}_{0},\n", mover, name);
        values["mover_parts"] += fmt::format("    .{} = &haptable_part_{},\n", pointer, part);
        values["mover_states"] += fmt::format("    struct haptable_{0}_state {0};\n", mover);
        values["mover_places"] += fmt::format("    .{0}_at = offsetof(struct {1}_state, {0}),\n", mover, name);
    };
    if (body != nullptr) add("body", "rigid", rigid_part_of(*body));
    if (body_modes != nullptr) add("modes", "ringing", "modes");
}

}  // namespace

std::vector<TableBytes> flash_tables(const ServoModel& model) {
    std::vector<TableBytes> tables;
    each_table(model, [&](const std::string& name, const char* /*count*/, const auto& rows) {
        tables.push_back({name, rows.size() * sizeof rows[0]});
    });
    return tables;
}

std::size_t flash_bytes(const ServoModel& model) {
    std::size_t bytes = 0;
    for (const TableBytes& table : flash_tables(model)) bytes += table.bytes;
    return bytes;
}

void require_flash(const std::vector<TableBytes>& tables, const ServoModel& model, std::uintmax_t budget_bytes) {
    std::size_t bytes = 0, blocks = 0;
    std::vector<std::string> list;
    for (const TableBytes& table : tables) {
        bytes += table.bytes;
        if (table.name == "stiffness_n_per_m" || table.name.ends_with("_compliance_m_per_n")) blocks += table.bytes;
        list.push_back(fmt::format("{} {}", table.name, table.bytes));
    }
    if (budget_bytes == 0 || bytes <= budget_bytes) return;
    const double share = static_cast<double>(budget_bytes) / static_cast<double>(bytes);
    const double fitting = std::floor(share * static_cast<double>(model.patch.size()));
    std::string advice = "not one patch would fit";
    if (fitting >= 1.0)
        advice = fmt::format("a [[touch]] region of about {:.0f} of its {} patches would fit, or a coarser mesh",
                             fitting, model.patch.size());
    if (bytes - blocks / 2 <= budget_bytes && blocks > 0)
        advice = fmt::format("precision = \"float16\" takes {} and fits", bytes - blocks / 2);
    throw Error(fmt::format("the servo's tables take {} bytes and tables.flash_budget is {}: {}; {}", bytes,
                            budget_bytes, fmt::join(list, ", "), advice));
}

namespace {

/// What leaves less of the servo's error, by making the same tables in other ways.
std::vector<Remedy> find_remedies(const Tables& tables, const ServoError& now) {
    std::vector<Remedy> found;
    const auto attempt = [&](const std::string& text, const Tables& other) {
        const double error = measure_servo(other, build_model(other)).worst;
        if (error < 0.5 * now.worst) found.push_back({text, error});
    };
    Tables moved = tables;
    for (auto& x : moved.position)
        for (std::size_t c = 0; c < 3; ++c) x[c] -= tables.position.front()[c];
    attempt("moving the mesh to the origin", moved);
    Tables coupled = tables;
    coupled.auto_coupling = true;
    if (!tables.auto_coupling) attempt("coupling = \"auto\" in [contact]", coupled);
    std::stable_sort(found.begin(), found.end(), [](const Remedy& a, const Remedy& b) { return a.error < b.error; });
    return found;
}

}  // namespace

std::string describe(const std::vector<Remedy>& remedies) {
    std::vector<std::string> list;
    for (const Remedy& remedy : remedies) list.push_back(fmt::format("{} leaves {:.2g}", remedy.text, remedy.error));
    return list.empty() ? "" : fmt::format("; {}", fmt::join(list, ", "));
}

ModelText model_text(const Tables& tables, const ServoModel& servo, const ServoPair* pair, const ServoModes* body_modes,
                     const haptable_body* body, const ToolTables* tool) {
    const haptable_model model = model_in_memory(tables, servo);
    const std::optional<haptable_pair_model> coupling =
        pair != nullptr ? std::optional(pair_in_memory(*pair, tables, model)) : std::nullopt;
    const ToolPoints points = tool != nullptr ? points_of(*tool) : ToolPoints();
    const std::optional<haptable_tool_model> held =
        tool != nullptr ? std::optional(tool_in_memory(*tool, points, coupling.value())) : std::nullopt;
    const haptable_tool_model* const its = held ? &*held : nullptr;
    const std::uint64_t hash = tables_hash(model, coupling && !held ? &*coupling : nullptr, body, body_modes, its);
    TemplateValues values = values_of(tables, servo, model, pair, body_modes, body, its);
    values["hash"] = fmt::format("{:016x}", hash);
    add_movers(body, body_modes, values);
    if (body_modes != nullptr) add_mode_values(*body_modes, values);
    if (pair != nullptr) add_pair_values(*pair, tables, model, values);
    if (held) add_tool_values(*held, values);
    return {filled(kHeaderText + 1, values), filled(kSourceText + 1, values)};
}

ModelSize generate_model(const TablesFolder& folder, bool writes_code) {
    const LoadedScene scene(read_scene_files(folder));
    const std::uint64_t hash = scene.model().hash;
    if (folder.tables_hash() != 0) scene.require_tables_hash(folder.tables_hash());
    const Tables& tables = scene.tables();
    ServoModel model = scene.servo();
    measure_search(model);
    ModelSize size{hash, flash_tables(model), {}, measure_servo(tables, model), {}, model.stiffness, model.search};
    if (!tables.display_rows.empty()) size.flash.push_back({"display", write_display(folder, tables, hash)});
    const ServoPair* const pair = scene.coupling();
    if (pair != nullptr)
        for (const TableBytes& table : flash_tables(*pair)) size.flash.push_back(table);
    const ServoModes* const body_modes = scene.servo_modes();
    if (body_modes != nullptr)
        for (const TableBytes& table : flash_tables(*body_modes)) size.flash.push_back(table);
    if (scene.tool() != nullptr)
        for (const TableBytes& table : flash_tables(scene.tool_points())) size.flash.push_back(table);
    require_flash(size.flash, model, tables.flash_budget);
    size.precision = compare_precisions(tables, model);
    require_precision(size.precision, tables.precision);
    if (size.servo.worst > kMostServoError) size.remedies = find_remedies(tables, size.servo);
    if (!has_definite_blocks(tables, model))
        throw Error(
            fmt::format("tables.precision = \"{}\" cannot hold the blocks S: rounded, some are no longer positive "
                        "definite, so that a force would pull where it should push{}",
                        word(tables.precision), describe(size.remedies)));
    if (!writes_code) return size;
    const ModelText text = model_text(tables, model, pair, body_modes, scene.body(), scene.tool_tables());
    write_file(folder.path() / "model.h", text.header);
    write_file(folder.path() / "model.c", text.source);
    return size;
}

}  // namespace haptable
