// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/scene/scene.hpp"

#include <fmt/format.h>

#include <stdexcept>
// The library's assertions fail on some files ("[#"): an exception reaches the user as an error, an abort does not.
[[noreturn]] static void fail_toml(const char* what) { throw std::logic_error(what); }
#define TOML_ASSERT(condition) ((condition) ? static_cast<void>(0) : fail_toml(#condition))
#include <toml++/toml.h>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <initializer_list>
#include <map>
#include <numbers>
#include <string_view>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/scene/device_models.hpp"
#include "host/scene/mass_range.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string_view>;

// A million nodes: beyond that the factor does not fit into the memory of a workstation.
constexpr std::int64_t kMostNodesPerSide = 100;

// Where a linear tetrahedron is half as stiff again as the body on any mesh of today.
constexpr double kMostPoissonOfLinear = 0.4999;

// A filled surface needs room for some tetrahedra.
constexpr std::int64_t kFewestNodes = 20;

// Diamond has 1.2e12 Pa; beyond these bounds the tables leave the range of float32.
constexpr double kSoftest_pa = 1e-3;
constexpr double kStiffest_pa = 1e15;

// Of a device's force: as old as the watchdogs let it be.
constexpr double kMostDelay_s = 0.02;

/// Levenshtein's distance: the fewest letters to insert, remove or change.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t diagonal = std::exchange(row[0], i + 1);
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t change = diagonal + (a[i] == b[j] ? 0 : 1);
            diagonal = row[j + 1];
            row[j + 1] = std::min({change, diagonal + 1, row[j] + 1});
        }
    }
    return row.back();
}

/// "; did you mean side?", or the list of what there is where nothing is near.
std::string suggest(std::string_view wrong, const Names& known) {
    std::string_view best;
    std::size_t least = std::max<std::size_t>(2, wrong.size() / 3) + 1;
    for (std::string_view name : known)
        if (const std::size_t distance = edit_distance(wrong, name); distance < least) {
            least = distance;
            best = name;
        }
    if (!best.empty()) return fmt::format("; did you mean {}?", best);
    return fmt::format("; known here: {}", fmt::join(known, ", "));
}

std::string_view type_name(const toml::node& node) {
    switch (node.type()) {
        case toml::node_type::table:
            return "a table";
        case toml::node_type::array:
            return node.is_array_of_tables() ? "a list of tables" : "a list";
        case toml::node_type::string:
            return "a text";
        case toml::node_type::integer:
            return "a whole number";
        case toml::node_type::floating_point:
            return "a number";
        case toml::node_type::boolean:
            return "true or false";
        default:
            return "a date or time";
    }
}

/// One table of the scene file: its keys are checked when it is made, its values when they are asked for.
class Section {
public:
    Section(const fs::path& file, std::string name, const toml::table& table, Names known)
        : file_(file), name_(std::move(name)), table_(table) {
        for (const auto& [key, node] : table_) {
            const std::string_view text = key.str();
            if (std::find(known.begin(), known.end(), text) == known.end())
                fail(text, "unknown key" + suggest(text, known));
        }
    }

    bool has(std::string_view key) const { return table_.contains(key); }

    /// Throws at the line of the key, or of its table where the key is missing.
    [[noreturn]] void fail(std::string_view key, const std::string& what) const {
        throw Error(fmt::format("{}:{}: {}: {}", file_.string(), line(key), full(key), what));
    }

    double number(std::string_view key, std::optional<double> fallback = {}) const {
        const toml::node* node = table_.get(key);
        if (node == nullptr && !fallback) missing(key, "a number");
        if (node == nullptr) return *fallback;
        const std::optional<double> value = node->value<double>();
        if (!value || node->is_boolean()) fail(key, fmt::format("must be a number, not {}", type_name(*node)));
        if (!std::isfinite(*value)) fail(key, "must be a finite number");
        return *value;
    }

    double positive(std::string_view key, std::optional<double> fallback = {}) const {
        const double value = number(key, fallback);
        if (!(value > 0.0)) fail(key, fmt::format("is {} and must be greater than 0", value));
        return value;
    }

    double not_negative(std::string_view key, double fallback) const {
        const double value = number(key, fallback);
        if (!(value >= 0.0)) fail(key, fmt::format("is {} and must not be less than 0", value));
        return value;
    }

    std::int64_t integer(std::string_view key, std::int64_t fallback) const {
        const toml::node* node = table_.get(key);
        if (node == nullptr) return fallback;
        if (!node->is_integer()) fail(key, fmt::format("must be a whole number, not {}", type_name(*node)));
        return node->as_integer()->get();
    }

    bool flag(std::string_view key, bool fallback) const {
        const toml::node* node = table_.get(key);
        if (node == nullptr) return fallback;
        if (!node->is_boolean()) fail(key, fmt::format("must be true or false, not {}", type_name(*node)));
        return node->as_boolean()->get();
    }

    /// A number above 0, or 0 for "off".
    double limit(std::string_view key, double fallback) const {
        if (!is_text(key)) return positive(key, fallback);
        if (text(key) != "off") fail(key, fmt::format("is \"{}\": give a number above 0, or \"off\"", text(key)));
        return 0.0;
    }

    bool is_text(std::string_view key) const { return table_.get(key) != nullptr && table_.get(key)->is_string(); }

    std::string text(std::string_view key, std::optional<std::string> fallback = {}) const {
        const toml::node* node = table_.get(key);
        if (node == nullptr && !fallback) missing(key, "a text");
        if (node == nullptr) return *fallback;
        if (!node->is_string()) fail(key, fmt::format("must be a text in quotes, not {}", type_name(*node)));
        return node->as_string()->get();
    }

    /// One of `have`; the first where it is left out.
    std::string choice(std::string_view key, const Names& have) const {
        std::string value = text(key, std::string(have.front()));
        if (std::find(have.begin(), have.end(), value) != have.end()) return value;
        fail(key, fmt::format("\"{}\" is not known{}", value, suggest(value, have)));
    }

    /// The same as an enum; all of its words, or the first ones.
    template <typename Choice>
    Choice one_of(std::string_view key, std::initializer_list<Choice> have = {}) const {
        Names names;
        for (const Choice one : have) names.emplace_back(word(one));
        if (names.empty())
            for (const char* one : words(Choice{})) names.emplace_back(one);
        return *choice_of<Choice>(choice(key, names));
    }

    /// The table of that name, with its keys checked; an empty one where it is left out.
    Section section(std::string_view key, Names known, bool required) const {
        static const toml::table empty;
        const toml::node* node = table_.get(key);
        if (node == nullptr && required) fail(key, fmt::format("is missing; add a table [{}]", key));
        if (node != nullptr && !node->is_table())
            fail(key, fmt::format("must be one table, [{}], not {}", key, type_name(*node)));
        return {file_, full(key), node == nullptr ? empty : *node->as_table(), std::move(known)};
    }

    /// All tables [[key]].
    std::vector<Section> sections(std::string_view key, const Names& known) const {
        std::vector<Section> all;
        const toml::node* node = table_.get(key);
        if (node == nullptr) return all;
        if (!node->is_array_of_tables())
            fail(key, fmt::format("must be a list of tables, [[{}]] with two brackets, not {}", key, type_name(*node)));
        for (const toml::node& entry : *node->as_array())
            all.push_back(Section(file_, full(key), *entry.as_table(), known));
        return all;
    }

    /// Mesh nodes, each once; none where the key is left out.
    std::vector<std::int32_t> nodes(std::string_view key) const {
        if (!has(key)) return {};
        const toml::array* list = table_.get_as<toml::array>(key);
        if (list == nullptr) fail(key, "must be a list of mesh nodes, like [0, 12, 57]");
        if (list->size() > 1000)
            fail(key, fmt::format("names {} nodes, and a target's display has at most 1000", list->size()));
        std::vector<std::int32_t> nodes;
        for (const toml::node& entry : *list) {
            const std::int64_t node = entry.is_integer() ? entry.as_integer()->get() : -1;
            if (node < 0 || node > std::numeric_limits<std::int32_t>::max())
                fail(key, "must be a list of mesh nodes, whole numbers from 0 on");
            if (std::find(nodes.begin(), nodes.end(), node) != nodes.end())
                fail(key, fmt::format("names node {} twice", node));
            nodes.push_back(static_cast<std::int32_t>(node));
        }
        return nodes;
    }

    std::array<double, 3> three(std::string_view key, const std::array<double, 3>& fallback) const {
        return has(key) ? list<3>(key, "three numbers: x y z") : fallback;
    }

    /// The number three times, or three of them.
    std::array<double, 3> one_or_three(std::string_view key, const std::array<double, 3>& fallback) const {
        if (!has(key) || table_.get(key)->is_array()) return three(key, fallback);
        const double value = number(key);
        return {value, value, value};
    }

    std::array<double, 6> box(std::string_view key) const {
        const std::array<double, 6> box_m = list<6>(key, "six numbers: xmin ymin zmin xmax ymax zmax (m)");
        for (std::size_t c = 0; c < 3; ++c)
            if (box_m[c] > box_m[c + 3])
                fail(key, fmt::format("{}min {} is greater than {}max {}; swap them", "xyz"[c], box_m[c], "xyz"[c],
                                      box_m[c + 3]));
        return box_m;
    }

    /// `count` finite numbers.
    std::vector<double> numbers(std::string_view key, std::size_t count, std::string_view example) const {
        if (!has(key)) missing(key, example);
        return finite(key, *table_.get(key), count, example);
    }

    /// Two vectors of three numbers.
    std::array<std::array<double, 3>, 2> two_vectors(std::string_view key, std::string_view example) const {
        const toml::array* list = table_.get_as<toml::array>(key);
        if (list == nullptr || list->size() != 2) fail(key, fmt::format("must be {}", example));
        std::array<std::array<double, 3>, 2> vectors{};
        for (std::size_t k = 0; k < 2; ++k) {
            const std::vector<double> v = finite(key, (*list)[k], 3, example);
            std::copy(v.begin(), v.end(), vectors[k].begin());
        }
        return vectors;
    }

    std::array<std::string, 2> two_texts(std::string_view key, std::string_view example) const {
        const toml::array* list = table_.get_as<toml::array>(key);
        std::array<std::string, 2> texts;
        for (std::size_t k = 0; k < 2; ++k) {
            const toml::value<std::string>* text =
                list == nullptr || list->size() != 2 ? nullptr : (*list)[k].as_string();
            if (text == nullptr || text->get().empty()) fail(key, fmt::format("must be {}", example));
            texts[k] = text->get();
        }
        return texts;
    }

    /// Line of the key, or of the table where it has no such key.
    int line(std::string_view key = {}) const {
        const auto entry = key.empty() ? table_.end() : table_.find(key);
        const toml::source_region& source = entry != table_.end() ? entry->first.source() : table_.source();
        return std::max(1, static_cast<int>(source.begin.line));
    }

private:
    std::vector<double> finite(std::string_view key, const toml::node& node, std::size_t count,
                               std::string_view example) const {
        const toml::array* list = node.as_array();
        std::vector<double> values;
        for (std::size_t k = 0; list != nullptr && k < list->size(); ++k) {
            const std::optional<double> value = (*list)[k].value<double>();
            if (value && !(*list)[k].is_boolean() && std::isfinite(*value)) values.push_back(*value);
        }
        if (list == nullptr || list->size() != count || values.size() != count)
            fail(key, fmt::format("must be {}", example));
        return values;
    }

    template <std::size_t Count>
    std::array<double, Count> list(std::string_view key, const char* what) const {
        const toml::array* list = table_.get_as<toml::array>(key);
        if (list == nullptr || list->size() != Count) fail(key, fmt::format("must be {}", what));
        std::array<double, Count> numbers{};
        for (std::size_t c = 0; c < Count; ++c) {
            const std::optional<double> value = (*list)[c].value<double>();
            if (!value || (*list)[c].is_boolean() || !std::isfinite(*value))
                fail(key, fmt::format("entry {} must be a finite number", c));
            numbers[c] = *value;
        }
        return numbers;
    }

    std::string full(std::string_view key) const {
        return name_.empty() ? std::string(key) : fmt::format("{}.{}", name_, key);
    }

    [[noreturn]] void missing(std::string_view key, std::string_view type) const {
        fail(key, fmt::format("is missing; give {}", type));
    }

    const fs::path& file_;
    std::string name_;
    const toml::table& table_;
};

/// Folders that make fills beside those of the scenes.
constexpr std::string_view kTaken[] = {"against",  "bin",      "codegen", "contact", "demo",   "error", "figures",
                                       "firmware", "fuzz",     "hard",    "host",    "large",  "lcm",   "lib",
                                       "masks",    "modes",    "package", "pic",     "python", "quick", "realtime",
                                       "report",   "sanitize", "scan",    "strokes", "tests",  "tidy",  "ways"};

/// The name is a folder's, a C identifier's (after codegen has mended it) and a message's.
std::string read_name(const Section& root) {
    const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
    const auto inner = [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '_' || c == '-'; };
    std::string name = root.text("name");
    if (name.empty() || name.size() > 64 || !letter(name[0]) || !std::all_of(name.begin(), name.end(), inner))
        root.fail("name", "must be a letter and then at most 63 letters, digits, '_' and '-'");
    if (std::find(std::begin(kTaken), std::end(kTaken), name) != std::end(kTaken))
        root.fail("name", fmt::format("\"{}\" is a folder of the build itself: choose another", name));
    return name;
}

void read_generator(const Section& mesh, MeshSource& source) {
    source.generate = mesh.choice("generate", {"cube"});
    if (mesh.has("linearize")) mesh.fail("linearize", "belongs to a mesh file; the cube is linear: remove it");
    for (const char* key : {"edge_length", "node_count", "wrap"})
        if (mesh.has(key)) mesh.fail(key, "belongs to a surface file that is filled; give the cube nodes_per_side");
    if (mesh.has("scale")) mesh.fail("scale", "belongs to a mesh file; give the cube's side in metres and remove it");
    const std::int64_t nodes = mesh.integer("nodes_per_side", source.nodes_per_side);
    if (nodes < 2 || nodes > kMostNodesPerSide)
        mesh.fail("nodes_per_side", fmt::format("is {} and must lie in 2..{}", nodes, kMostNodesPerSide));
    source.nodes_per_side = static_cast<int>(nodes);
    source.side_m = mesh.positive("side", source.side_m);
}

void read_mesh_file(const Section& mesh, const fs::path& scene_file, MeshSource& source) {
    for (const char* key : {"nodes_per_side", "side"})
        if (mesh.has(key)) mesh.fail(key, "belongs to generate = \"cube\"; remove it or the file");
    const std::string file = mesh.text("file");
    if (file.empty()) mesh.fail("file", "is empty; name a mesh file, relative to the scene");
    source.file = scene_file.parent_path() / file;
    source.scale_m = mesh.positive("scale", source.scale_m);
    source.linearize = mesh.flag("linearize", false);
    if (mesh.has("edge_length") && mesh.has("node_count"))
        mesh.fail("node_count", "there is an edge_length too; keep one of them");
    if (mesh.has("wrap")) source.wrap = mesh.flag("wrap", false);
    if (source.wrap && !mesh.has("edge_length") && !mesh.has("node_count"))
        mesh.fail("wrap", "belongs to a surface that is filled; give node_count or edge_length, or remove it");
    if (mesh.has("edge_length")) source.edge_length_m = mesh.positive("edge_length");
    if (!mesh.has("node_count")) return;
    const std::int64_t nodes = mesh.integer("node_count", 0);
    if (nodes < kFewestNodes) mesh.fail("node_count", fmt::format("is {} and must be {} or more", nodes, kFewestNodes));
    source.node_count = static_cast<std::size_t>(nodes);
}

MeshSource read_source(const Section& root, const fs::path& scene_file) {
    const Section mesh = root.section("mesh",
                                      {"element", "generate", "nodes_per_side", "side", "file", "scale", "linearize",
                                       "edge_length", "node_count", "wrap"},
                                      true);
    if (mesh.has("generate") && mesh.has("file"))
        mesh.fail("file", "there is a generator too; keep either generate or file");
    if (!mesh.has("generate") && !mesh.has("file"))
        mesh.fail("file", "is missing; give a mesh file, or generate = \"cube\"");
    MeshSource source;
    source.element = mesh.one_of<Element>("element");
    if (mesh.has("generate"))
        read_generator(mesh, source);
    else
        read_mesh_file(mesh, scene_file, source);
    return source;
}

double read_modulus(const Section& section, std::string_view key, double value_pa) {
    if (!(value_pa > 0.0)) section.fail(key, fmt::format("is {} and must be greater than 0", value_pa));
    if (value_pa < kSoftest_pa || value_pa > kStiffest_pa)
        section.fail(key, fmt::format("is {} Pa and must lie in {}..{}", value_pa, kSoftest_pa, kStiffest_pa));
    return value_pa;
}

/// Of linear tetrahedra a bound below 0.5.
void require_compressible(const Section& section, double poisson, std::string_view like, Element element) {
    if (element == Element::kLinear && poisson > kMostPoissonOfLinear)
        section.fail("poisson",
                     fmt::format("{}is {}, and linear tetrahedra above {} give the mesh's stiffness, not the "
                                 "body's: write element = \"{}\" in [mesh]",
                                 like, poisson, kMostPoissonOfLinear, word(Element::kAverageNodalPressure)));
}

Material read_isotropic(const Section& section, Element element) {
    Material material;
    material.young_pa = read_modulus(section, "young", section.number("young"));
    material.poisson = section.number("poisson");
    if (!(material.poisson > -1.0 && material.poisson < 0.5))
        section.fail("poisson", fmt::format("is {} and must lie between -1 and 0.5, both excluded; 0.5 is "
                                            "incompressible, which this method cannot do: use 0.49",
                                            material.poisson));
    require_compressible(section, material.poisson, "", element);
    return material;
}

using Vector = std::array<double, 3>;

double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Not 0, and the second not along the first.
void require_directions(const Section& section, std::string_view key, const Vector& first, const Vector* second) {
    const double a = dot(first, first);
    if (!(a > 0.0)) section.fail(key, "is 0, which is no direction");
    if (second == nullptr) return;
    const double b = dot(*second, *second), ab = dot(first, *second);
    constexpr double kLeastSine = 1e-6;
    if (!(b > 0.0) || !(a * b - ab * ab > kLeastSine * kLeastSine * a * b))
        section.fail(key, "its two directions must not be parallel, nor 0");
}

/// [[x, y, z], [x, y, z]]: a point of the axis and its direction.
void read_around(const Section& section, MaterialAxes& axes) {
    axes.around = section.two_vectors("around", "a point (m) and a direction, [[0, 0, 0], [0, 0, 1]]");
    require_directions(section, "around", (*axes.around)[1], nullptr);
}

/// One of three keys says how the material lies: `vectors`, `vectors`_field or around.
MaterialAxes read_axes(const Section& section, const std::string& vectors, bool two) {
    MaterialAxes axes;
    axes.line = section.line();
    const std::string field = vectors + "_field";
    if (section.has(vectors) + section.has(field) + section.has("around") != 1)
        section.fail(vectors, fmt::format("say how the material lies by one of {}, {} and around", vectors, field));
    if (section.has("around")) {
        read_around(section, axes);
    } else if (section.has(field)) {
        if (two)
            axes.field = section.two_texts(field, "two names of cell vectors of the mesh file, [\"u\", \"v\"]");
        else
            axes.field[0] = section.text(field);
        if (axes.field[0].empty()) section.fail(field, "is empty; name cell vectors of the mesh file");
    } else if (two) {
        axes.direction = section.two_vectors(vectors, "two directions, [[1, 0, 0], [0, 1, 0]]");
        require_directions(section, vectors, axes.direction[0], &axes.direction[1]);
    } else {
        const std::vector<double> v = section.numbers(vectors, 3, "a direction, [1, 0, 0]");
        std::copy(v.begin(), v.end(), axes.direction[0].begin());
        require_directions(section, vectors, axes.direction[0], nullptr);
    }
    return axes;
}

/// Both laws end alike: admissible, and as compressible as the element needs.
Material finish(const Section& section, const Orthotropic& law, Element element) {
    if (const std::string what = violated(law); !what.empty())
        section.fail("poisson", "the stiffness is not positive definite: " + what);
    Material material = like(law);
    require_compressible(section, material.poisson, "of the like isotropic material ", element);
    return material;
}

Material read_orthotropic(const Section& section, Element element) {
    const auto three = [&](std::string_view key, std::string_view example) {
        const std::vector<double> v = section.numbers(key, 3, example);
        return Vector{v[0], v[1], v[2]};
    };
    Orthotropic law{three("young", "three moduli, [E1, E2, E3]"), three("poisson", "three ratios, [nu12, nu13, nu23]"),
                    three("shear", "three moduli, [G12, G13, G23]"), read_axes(section, "axes", true)};
    for (double e : law.young_pa) read_modulus(section, "young", e);
    for (double g : law.shear_pa) read_modulus(section, "shear", g);
    return finish(section, law, element);
}

Material read_fibre(const Section& section, Element element) {
    const auto modulus = [&](std::string_view key) { return read_modulus(section, key, section.number(key)); };
    const double across = section.number("poisson_across");
    if (!(across > -1.0 && across < 1.0))
        section.fail("poisson_across", fmt::format("is {} and must lie between -1 and 1, both excluded", across));
    Orthotropic law =
        fibre(modulus("young_along"), modulus("young_across"), section.number("poisson"), across, modulus("shear"));
    law.axes = read_axes(section, "direction", false);
    return finish(section, law, element);
}

/// Keys of each law, besides a region's box or group.
const std::map<std::string, Names> kLaws{
    {"isotropic", {"law", "young", "poisson"}},
    {"orthotropic", {"law", "young", "poisson", "shear", "axes", "axes_field", "around"}},
    {"fibre",
     {"law", "young_along", "young_across", "poisson", "poisson_across", "shear", "direction", "direction_field",
      "around"}}};

/// Of all laws.
Names material_keys(Names also = {}) {
    for (const auto& [law, keys] : kLaws)
        for (std::string_view key : keys)
            if (std::find(also.begin(), also.end(), key) == also.end()) also.push_back(key);
    return also;
}

Material read_material(const Section& section, Element element) {
    const std::string law = section.choice("law", {"isotropic", "orthotropic", "fibre"});
    const Names& own = kLaws.at(law);
    for (std::string_view key : material_keys())
        if (section.has(key) && std::find(own.begin(), own.end(), key) == own.end())
            section.fail(key, fmt::format("does not belong to law = \"{}\", whose keys are {}", law,
                                          fmt::join(own.begin() + 1, own.end(), ", ")));
    if (law == "orthotropic") return read_orthotropic(section, element);
    return law == "fibre" ? read_fibre(section, element) : read_isotropic(section, element);
}

/// "box" or "group", one of them.
Selection read_selection(const Section& section) {
    Selection selection;
    selection.line = section.line();
    if (section.has("box") == section.has("group")) section.fail("box", "give either a box or a group");
    if (section.has("box")) {
        selection.box_m = section.box("box");
    } else {
        selection.group = section.text("group");
        if (selection.group.empty()) section.fail("group", "is empty; name a group of the mesh file");
    }
    return selection;
}

/// A layer of `below` metres, from the lowest node along `axis` on.
Selection read_layer(const Section& section) {
    for (const char* key : {"box", "group"})
        if (section.has(key)) section.fail(key, "there is below too; keep one of them");
    const std::string axis = section.choice("axis", {"z", "x", "y", "-x", "-y", "-z"});
    Selection selection;
    selection.line = section.line();
    selection.below = Below{section.not_negative("below", 0.0), axis.back() - 'x', axis.front() == '-'};
    return selection;
}

std::vector<Selection> read_fixed(const Section& root) {
    std::vector<Selection> selections;
    for (const Section& section : root.sections("fixed", {"box", "group", "below", "axis"})) {
        if (section.has("axis") && !section.has("below")) section.fail("axis", "belongs to below, metres; give it");
        if (!section.has("below") && !section.has("box") && !section.has("group"))
            section.fail("below", "give a box, a group or below");
        selections.push_back(section.has("below") ? read_layer(section) : read_selection(section));
    }
    return selections;
}

std::vector<Selection> read_touch(const Section& root) {
    std::vector<Selection> selections;
    for (const Section& section : root.sections("touch", {"box", "group", "cavities"})) {
        selections.push_back(read_selection(section));
        selections.back().cavities = section.flag("cavities", false);
    }
    return selections;
}

std::vector<Region> read_regions(const Section& root, Element element) {
    std::vector<Region> regions;
    for (const Section& section : root.sections("region", material_keys({"box", "group", "density"}))) {
        regions.push_back({read_selection(section), read_material(section, element)});
        if (!section.has("density")) continue;
        if (!root.has("gravity") && !root.has("body"))
            section.fail("density", "belongs to a scene with [gravity]; add that table");
        regions.back().density_kg_per_m3 = section.positive("density");
    }
    return regions;
}

std::vector<Membrane> read_membranes(const Section& root) {
    std::vector<Membrane> membranes;
    for (const Section& section : root.sections("membrane", {"box", "group", "thickness", "young", "poisson"})) {
        Membrane membrane{read_selection(section), section.positive("thickness"),
                          read_modulus(section, "young", section.number("young")), section.number("poisson")};
        if (!(membrane.poisson > -1.0 && membrane.poisson <= 0.5))
            section.fail("poisson", fmt::format("is {} and must lie above -1 and be at most 0.5", membrane.poisson));
        membranes.push_back(membrane);
    }
    return membranes;
}

std::vector<Bed> read_beds(const Section& root) {
    std::vector<Bed> beds;
    for (const Section& section : root.sections("bed", {"box", "group", "normal", "tangential"})) {
        beds.push_back(
            {read_selection(section), section.not_negative("normal", 0.0), section.not_negative("tangential", 0.0)});
        if (!(beds.back().normal_n_per_m3 + beds.back().tangential_n_per_m3 > 0.0))
            section.fail("normal", "give normal or tangential, in N/m^3, greater than 0");
    }
    return beds;
}

constexpr std::size_t kMostTerms = 8;  // HAPTABLE_TERMS: the servo's state

std::vector<RelaxationTerm> read_relaxation(const Section& root) {
    std::vector<RelaxationTerm> terms;
    for (const Section& section : root.sections("relaxation", {"share", "time"})) {
        terms.push_back({section.positive("share"), section.positive("time")});
        if (!(rest_share(terms) > 1e-6))
            section.fail("share",
                         fmt::format("brings the sum of all shares to {:g}, and a body whose stiffness relaxes "
                                     "to nothing flows: keep the sum below 1",
                                     1.0 - rest_share(terms)));
        if (terms.size() > kMostTerms)
            section.fail("time", fmt::format("is of term {}, and a servo has at most {}", terms.size(), kMostTerms));
    }
    return terms;
}

std::optional<Gravity> read_gravity(const Section& root) {
    if (!root.has("gravity")) return {};
    const Section section = root.section("gravity", {"density", "direction", "acceleration", "prestress"}, true);
    Gravity gravity;
    gravity.density_kg_per_m3 = section.positive("density");
    gravity.prestress = section.flag("prestress", false);
    Vector direction{0.0, 0.0, -1.0};
    if (section.has("direction")) {
        const std::vector<double> v = section.numbers("direction", 3, "a direction, [0, 0, -1]");
        std::copy(v.begin(), v.end(), direction.begin());
        require_directions(section, "direction", direction, nullptr);
    }
    const double scale = section.positive("acceleration", 9.81) / std::sqrt(dot(direction, direction));
    for (std::size_t c = 0; c < 3; ++c) gravity.acceleration_m_per_s2[c] = scale * direction[c];
    return gravity;
}

std::array<double, 6> read_six(const Section& section, std::string_view key) {
    std::array<double, 6> six{};
    if (!section.has(key)) return six;
    const std::vector<double> v = section.numbers(key, 6, "six: along x, y, z, then about them");
    for (std::size_t i = 0; i < 6; ++i) {
        if (!(v[i] >= 0.0)) section.fail(key, fmt::format("has {}, and none may be less than 0", v[i]));
        six[i] = v[i];
    }
    return six;
}

std::optional<FreeBody::Floor> read_floor(const Section& section, const std::optional<Gravity>& gravity) {
    for (const std::string_view key : {"floor_normal", "floor_friction"})
        if (section.has(key) && !section.has("floor")) section.fail(key, "needs floor, its height; give it");
    if (!section.has("floor")) return {};
    FreeBody::Floor floor{section.number("floor"), {0.0, 0.0, 1.0}, section.not_negative("floor_friction", 0.5)};
    if (gravity)
        for (std::size_t c = 0; c < 3; ++c) floor.normal[c] = -gravity->acceleration_m_per_s2[c];
    if (section.has("floor_normal")) {
        const std::vector<double> v = section.numbers("floor_normal", 3, "a direction, [0, 0, 1]");
        std::copy(v.begin(), v.end(), floor.normal.begin());
        require_directions(section, "floor_normal", floor.normal, nullptr);
    }
    const double length = std::sqrt(dot(floor.normal, floor.normal));
    for (double& n : floor.normal) n /= length;
    return floor;
}

/// A body that is not held has nothing else that holds it, and how heavy it is from one place.
void require_free(const Section& root, const Section& section, const std::optional<Gravity>& gravity) {
    for (const char* holds : {"fixed", "bed"})
        if (root.has(holds))
            section.fail("free", fmt::format("is true, and [[{}]] holds the body; remove one of them", holds));
    if (gravity && gravity->prestress)
        section.fail("free", "is true, and prestress needs a body that is held under its weight; remove that");
    if (gravity && section.has("density")) section.fail("density", "is in [gravity] already; remove one of them");
    if (!gravity && !section.has("density") && !section.has("mass"))
        section.fail("density", "is missing: a body that is not held needs a density or a mass, or [gravity]");
    if (section.has("suspension_damping") && !section.has("suspension"))
        section.fail("suspension_damping", "needs suspension, six stiffnesses; give them");
}

double read_mass(const Section& section) {
    const double mass_kg = section.positive("mass");
    if (!(mass_kg >= kLeastMass_kg && mass_kg <= kMostMass_kg))
        section.fail("mass", fmt::format("is {:g} kg, and a servo moves {:g} to {:g} kg: give it in kg", mass_kg,
                                         kLeastMass_kg, kMostMass_kg));
    return mass_kg;
}

Section body_section(const Section& root) {
    return root.section("body",
                        {"free", "density", "mass", "suspension", "suspension_damping", "floor", "floor_normal",
                         "floor_friction", "modes", "mode_damping"},
                        false);
}

std::optional<FreeBody> read_free_body(const Section& root, const std::optional<Gravity>& gravity) {
    if (!root.has("body")) return {};
    const Section section = body_section(root);
    if (!section.flag("free", false)) {
        for (const std::string_view key :
             {"suspension", "suspension_damping", "floor", "floor_normal", "floor_friction"})
            if (section.has(key)) section.fail(key, "is of a body that is not held; add free = true");
        for (const std::string_view key : {"density", "mass"})
            if (section.has(key) && !section.has("modes"))
                section.fail(key, "is of a body that moves; add free = true or modes");
        return {};
    }
    require_free(root, section, gravity);
    FreeBody body;
    if (section.has("density")) body.density_kg_per_m3 = section.positive("density");
    if (section.has("mass")) body.mass_kg = read_mass(section);
    body.stiffness = read_six(section, "suspension");
    body.damping = read_six(section, "suspension_damping");
    body.floor = read_floor(section, gravity);
    body.line = section.line("free");
    return body;
}

// HAPTABLE_MODES: the servo's state.
constexpr int kMostModes = 16;

/// Of jelly and soft tissue, ratios of 0.03 to 0.3 are reported; 0.05 rings for some ten swings.
constexpr double kModeDamping = 0.05, kLeastModeDamping = 1e-4;

/// How heavy a body that is held is, which nothing but its modes asks for.
void require_weight(const Section& section, const std::optional<Gravity>& gravity) {
    if (gravity && section.has("density")) section.fail("density", "is in [gravity] already; remove one of them");
    if (!gravity && !section.has("density") && !section.has("mass"))
        section.fail("density", "is missing: a body that rings needs a density or a mass, or [gravity]");
}

/// What has no modes yet.
void require_ringing(const Section& section, const Scene& scene) {
    if (scene.gravity && scene.gravity->prestress)
        section.fail("modes", "are those of the body without stress; remove prestress, or modes");
    if (!scene.relaxation.empty()) section.fail("modes", "are of an elastic body: remove [[relaxation]], or modes");
    if (scene.contact.passivity)
        section.fail("modes", "count what contacts give themselves: remove passivity, or modes");
}

std::optional<Vibration> read_vibration(const Section& root, const Scene& scene) {
    if (!root.has("body")) return {};
    const Section section = body_section(root);
    if (section.has("mode_damping") && !section.has("modes"))
        section.fail("mode_damping", "needs modes, how many ring; give it");
    if (!section.has("modes")) return {};
    Vibration vibration;
    const std::int64_t modes = section.integer("modes", 0);
    if (modes < 0 || modes > kMostModes)
        section.fail("modes", fmt::format("is {}, and a servo has 0 to {}", modes, kMostModes));
    vibration.modes = static_cast<int>(modes);
    vibration.damping_ratio = section.positive("mode_damping", kModeDamping);
    if (!(vibration.damping_ratio >= kLeastModeDamping && vibration.damping_ratio < 1.0))
        section.fail("mode_damping",
                     fmt::format("is {}, the ratio to critical damping, and must be at least {} and below 1",
                                 vibration.damping_ratio, kLeastModeDamping));
    if (vibration.modes == 0) return {};
    require_ringing(section, scene);
    if (!section.flag("free", false)) {
        require_weight(section, scene.gravity);
        if (section.has("density")) vibration.density_kg_per_m3 = section.positive("density");
        if (section.has("mass")) vibration.mass_kg = read_mass(section);
    }
    vibration.line = section.line("modes");
    return vibration;
}

/// Cell vectors that any material is turned by: what the mesh's reader must keep.
void collect_directions(Scene& scene) {
    const auto collect = [&](const Material& material) {
        if (!material.orthotropic) return;
        for (const std::string& field : material.orthotropic->axes.field)
            if (!field.empty()) scene.mesh.directions.push_back(field);
    };
    collect(scene.material);
    for (const Region& region : scene.regions) collect(region.material);
    if (!scene.mesh.directions.empty() && !scene.mesh.generate.empty())
        throw Error(fmt::format("{}: cell vectors belong to a mesh file, and the cube is generated; give axes",
                                scene.file.string()));
}

void read_friction(const Section& section, ContactOptions& contact) {
    contact.static_friction = section.not_negative("friction", 0.0);
    if (section.has("kinetic_friction") && contact.static_friction == 0.0)
        section.fail("kinetic_friction", "needs friction, the static coefficient; give it or remove this line");
    if (contact.static_friction == 0.0) return;
    contact.kinetic_friction = section.positive("kinetic_friction", contact.static_friction);
    if (contact.kinetic_friction > contact.static_friction)
        section.fail("kinetic_friction", fmt::format("is {} and must not be greater than friction, {}",
                                                     contact.kinetic_friction, contact.static_friction));
}

/// coupling = "auto" | "none" | N/m
void read_coupling(const Section& section, ContactOptions& contact) {
    if (!section.has("coupling")) return;
    if (section.is_text("coupling"))
        contact.auto_coupling = section.choice("coupling", {"none", "auto"}) == "auto";
    else
        contact.coupling_n_per_m = section.positive("coupling");
}

/// N/ms by which a jump of the least-energy god-object is brought down where the scene does not say: a step of 10 mN is
/// hardly felt, and a force of 1 N is gone in a tenth of a second.
constexpr double kReleaseOfJumps = 0.01;

/// A body that nothing holds pays with its motion for what contacts make. What is neither hand, contact nor motion it
/// cannot count: a force that goes on after its contact, or that brakes a hand, would throw it about.
void require_contact_alone(const Section& section, const ContactOptions& contact) {
    if (section.has("release_slew") && contact.release_n_per_ms > 0.0)
        section.fail("release_slew",
                     "keeps a force up that has ended, and a body that is free would be thrown by it; remove it");
    if (contact.passivity)
        section.fail("passivity", "is what the motion of a body that is free does already; remove it");
}

ContactOptions read_contact(const Section& root, bool is_free) {
    const Section section =
        root.section("contact",
                     {"force", "god_object", "rigid_stiffness", "mask_radius", "friction", "kinetic_friction",
                      "release_slew", "coupling", "passivity", "grab", "fingers"},
                     false);
    ContactOptions contact;
    contact.force = section.one_of<ForceLaw>("force");
    // A body that is free is not to be given energy, and the nearest one gives some.
    contact.god_object = is_free ? section.one_of("god_object", {GodObject::kLeastEnergy, GodObject::kNearest})
                                 : section.one_of<GodObject>("god_object");
    contact.rigid_stiffness_n_per_m = section.positive("rigid_stiffness", contact.rigid_stiffness_n_per_m);
    if (contact.force == ForceLaw::kPressureMask)
        contact.mask_radius_m = section.positive("mask_radius");
    else if (section.has("mask_radius"))
        section.fail("mask_radius", "belongs to force = \"pressure-mask\"; remove it or choose that force");
    read_friction(section, contact);
    const bool jumps = contact.god_object == GodObject::kLeastEnergy;  // from one minimum to another
    contact.release_n_per_ms = section.not_negative("release_slew", jumps && !is_free ? kReleaseOfJumps : 0.0);
    contact.passivity = section.flag("passivity", false);
    contact.grab = section.flag("grab", false);
    const std::int64_t fingers = section.integer("fingers", contact.fingers);
    if (fingers != 1 && fingers != 2) section.fail("fingers", fmt::format("is {} and must be 1 or 2", fingers));
    contact.fingers = static_cast<int>(fingers);
    read_coupling(section, contact);
    if (is_free) require_contact_alone(section, contact);
    return contact;
}

// Where the scene does not say, what a desktop device and a hand are expected to keep to. A hand moves no faster than
// HAPTABLE_FAST_SEGMENT_M a tick.
constexpr double kMaxSpeed = 5.0;        // m/s
constexpr double kFullForceTime = 0.01;  // s, from none to max_force
constexpr double kRampTime = 1.0;        // s

/// max_speed, max_force_rate, mean_force = a number | "off"; force_return = "leaving" | "ramp"
SafetyLimits read_limits(const Section& section, const Device& device) {
    SafetyLimits limits;
    limits.max_speed_m_s = section.limit("max_speed", kMaxSpeed);
    limits.max_force_rate_n_per_s = section.limit("max_force_rate", device.max_force_n / kFullForceTime);
    limits.mean_force_n = section.limit("mean_force", device.continuous_force_n);
    limits.mean_force_time_s = section.positive("mean_force_time", limits.mean_force_time_s);
    const bool ramps = section.choice("force_return", {"leaving", "ramp"}) == "ramp";
    if (!ramps && section.has("ramp_time"))
        section.fail("ramp_time", "belongs to force_return = \"ramp\"; remove it or choose that");
    if (ramps) limits.ramp_s = section.positive("ramp_time", kRampTime);
    return limits;
}

/// The model's figures where the scene gives none.
Device read_device(const Section& section) {
    Names names;
    for (const DeviceModel& model : device_models()) names.emplace_back(model.name);
    Device device = device_of(*find_device_model(section.choice("model", names)));
    device.max_force_n = section.positive("max_force", device.max_force_n);
    device.mass_kg = section.one_or_three("mass", device.mass_kg);
    for (const double mass_kg : device.mass_kg)
        if (!(mass_kg > 0.0)) section.fail("mass", fmt::format("is {} and must be greater than 0", mass_kg));
    device.damping_n_s_per_m = section.not_negative("damping", device.damping_n_s_per_m);
    device.friction_n = section.not_negative("friction", device.friction_n);
    device.encoder_step_m = section.not_negative("encoder_step", device.encoder_step_m);
    device.bandwidth_hz = section.not_negative("bandwidth", device.bandwidth_hz);
    device.delay_s = section.not_negative("delay", device.delay_s);
    if (device.delay_s > kMostDelay_s)
        section.fail("delay", fmt::format("is {} s, and a servo takes what is {} s old for silence", device.delay_s,
                                          kMostDelay_s));
    device.limits = read_limits(section, device);
    return device;
}

DeviceMap read_device_map(const Section& section) {
    DeviceMap map;
    map.position_m = section.three("position", map.position_m);
    map.rotation_deg = section.three("rotation", map.rotation_deg);
    map.left_handed = section.choice("handedness", {"right", "left"}) == "left";
    map.motion_scale = section.positive("motion_scale", map.motion_scale);
    map.force_scale = section.positive("force_scale", map.force_scale);
    map.ramp_s = section.not_negative("clutch_ramp", map.ramp_s);
    if (section.has("workspace")) map.workspace_m = section.box("workspace");
    return map;
}

/// What two fingers need besides.
void read_coupling_bytes(const Section& section, const ContactOptions& contact, TableOptions& tables) {
    const std::int64_t bytes = section.integer("coupling_bytes", static_cast<std::int64_t>(tables.coupling_bytes));
    if (section.has("coupling_bytes") && contact.fingers == 1)
        section.fail("coupling_bytes", "belongs to two fingers; write fingers = 2 in [contact], or remove it");
    if (bytes <= 0) section.fail("coupling_bytes", fmt::format("is {} and must be greater than 0 (bytes)", bytes));
    tables.coupling_bytes = static_cast<std::uintmax_t>(bytes);
}

TableOptions read_table_options(const Section& root, const ContactOptions& contact) {
    const Section section = root.section("tables",
                                         {"precision", "columns", "column_precision", "column_budget", "flash_budget",
                                          "display_rows", "display_precision", "check", "coupling_bytes"},
                                         false);
    TableOptions tables;
    tables.precision = section.one_of<Storage>("precision");
    tables.columns = section.one_of<ColumnRows>("columns");
    tables.column_precision = section.one_of<Storage>("column_precision", {Storage::kFloat32, Storage::kFloat16});
    tables.column_budget_bytes = section.not_negative("column_budget", tables.column_budget_bytes);
    const std::int64_t budget = section.integer("flash_budget", 0);
    if (section.has("flash_budget") && budget <= 0)
        section.fail("flash_budget", fmt::format("is {} and must be greater than 0 (bytes)", budget));
    tables.flash_budget = static_cast<std::uintmax_t>(budget);
    tables.check = section.flag("check", true);
    read_coupling_bytes(section, contact, tables);
    tables.display_rows = section.nodes("display_rows");
    tables.display_precision = section.one_of<Storage>("display_precision", {Storage::kFloat32, Storage::kInt16});
    if (section.has("display_precision") && tables.display_rows.empty())
        section.fail("display_precision",
                     "is of display_rows, which the microcontroller computes; give them, or remove "
                     "it");
    if (!tables.display_rows.empty() && tables.columns == ColumnRows::kNone)
        section.fail("display_rows", "needs columns, and columns = \"none\" leaves them out");
    if (!tables.display_rows.empty() && tables.column_precision != Storage::kFloat32)
        section.fail("display_rows", "needs columns in float32: remove column_precision");
    if (!tables.display_rows.empty() && contact.force == ForceLaw::kPressureMask)
        section.fail("display_rows", "a pressure mask spreads its load over nodes that only the host knows");
    return tables;
}

/// Where the comment or text that begins at `at` ends: behind it. A quote that begins no text, for it is in the middle
/// of something or is not closed, ends at once.
std::size_t skip_quoted(std::string_view text, std::size_t at) {
    if (text[at] == '#') return std::min(text.find('\n', at), text.size());
    if (at > 0 && std::string_view("=,[{ \t\r\n").find(text[at - 1]) == std::string_view::npos) return at + 1;
    const std::string three(3, text[at]);
    const bool long_one = text.substr(at, 3) == three;
    const std::string_view end = long_one ? std::string_view(three) : std::string_view(three).substr(2);
    for (std::size_t k = at + end.size(); k < text.size(); ++k) {
        if (text[at] == '"' && text[k] == '\\')
            ++k;
        else if (text.substr(k, end.size()) == end)
            return k + end.size();
        else if (!long_one && text[k] == '\n')
            break;
    }
    return long_one ? text.size() : at + 1;
}

[[noreturn]] void fail_at(const fs::path& file, std::string_view text, std::size_t at, const char* what) {
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    throw Error(fmt::format("{}:{}: {}", file.string(), line, what));
}

/// One beyond ASCII.
bool has_letter(std::string_view text) {
    return std::any_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) >= 0x80; });
}

/// A text of several lines whose line breaks are escaped: the library asks whether what follows is a blank, which it
/// cannot tell of letters beyond ASCII.
bool is_undefined(std::string_view quoted) {
    return quoted.starts_with("\"\"\"") && quoted.find('\\') != std::string_view::npos && has_letter(quoted);
}

/// What TOML does not allow and the library's behaviour is undefined for: control characters anywhere, and letters
/// beyond ASCII outside of texts and comments.
void require_letters(const fs::path& file, std::string_view text) {
    for (std::size_t at = 0; at < text.size(); ++at)
        if ((static_cast<unsigned char>(text[at]) < ' ' &&
             std::string_view("\t\n\r").find(text[at]) == std::string_view::npos) ||
            text[at] == 0x7f)
            fail_at(file, text, at, "a control character; this is not a text file, or a damaged one");
    for (std::size_t at = 0; at < text.size();)
        if (text[at] == '#' || text[at] == '"' || text[at] == '\'') {
            const std::size_t end = skip_quoted(text, at);
            if (is_undefined(text.substr(at, end - at)))
                fail_at(file, text, at,
                        "a text of several lines with backslashes and letters beyond ASCII; write it on one line");
            if (text[at] != '#' && end == at + 1 && has_letter(text.substr(end)))
                fail_at(file, text, at, "a quote in the middle of something, and letters beyond ASCII after it");
            at = end;
        } else if (static_cast<unsigned char>(text[at++]) >= 0x80)
            fail_at(file, text, at,
                    "a character that is not ASCII stands outside of quotes; write keys in letters a to z");
}

/// A mesh file, by how it begins or by its name: what a stranger tries first.
bool is_mesh(const fs::path& file, std::string_view text) {
    for (const char* begin : {"solid", "ply", "OFF", "$MeshFormat", "$NOD", "# vtk", "<?xml", "<VTKFile", "MeshVersion",
                              "*NODE", "*HEADING", "*VERTICES"})
        if (text.starts_with(begin)) return true;
    std::string kind = file.extension().string();
    for (char& c : kind) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    const Names kinds{".stl", ".ply", ".off", ".obj", ".msh", ".vtk", ".vtu", ".mesh", ".node", ".ele", ".inp", ".veg"};
    return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
}

toml::table parse(const fs::path& file) {
    const std::string text = read_text(file);
    if (is_mesh(file, text))
        throw Error(
            fmt::format("{}: is a mesh, and a scene is asked for: write a file scene.toml with file = \"{}\" in "
                        "its [mesh], a [material] and what holds it; README.md has one under \"Your own mesh\"",
                        file.string(), file.filename().string()));
    require_letters(file, text);
    try {
        return toml::parse(text);
    } catch (const toml::parse_error& error) {
        throw Error(fmt::format("{}:{}: {} (column {}); docs/SCENE.md has every key", file.string(),
                                error.source().begin.line, error.description(), error.source().begin.column));
    } catch (const std::logic_error&) {
        throw Error(file.string() +
                    ": is not TOML: a table's header or a key has no name; docs/SCENE.md has every "
                    "key");
    }
}

}  // namespace

double servo_force_limit_n(const Scene& scene) { return scene.device.max_force_n / scene.device_map.force_scale; }

double whole_delay_s(const Device& device) {
    const double lag_s = device.bandwidth_hz > 0.0 ? 1.0 / (2.0 * std::numbers::pi * device.bandwidth_hz) : 0.0;
    return device.delay_s + lag_s;
}

SafetyLimits servo_limits(const Scene& scene) {
    SafetyLimits limits = scene.device.limits;
    limits.max_speed_m_s *= scene.device_map.motion_scale;
    limits.max_force_rate_n_per_s /= scene.device_map.force_scale;
    limits.mean_force_n /= scene.device_map.force_scale;
    return limits;
}

Scene read_scene(const fs::path& file) {
    const toml::table table = parse(file);
    const Section root(file, "", table,
                       {"name", "mesh", "material", "region", "fixed", "membrane", "bed", "gravity", "relaxation",
                        "touch", "contact", "device", "tables", "body"});
    Scene scene;
    scene.file = file;
    scene.name = read_name(root);
    scene.mesh = read_source(root, file);
    scene.material = read_material(root.section("material", material_keys(), true), scene.mesh.element);
    scene.regions = read_regions(root, scene.mesh.element);
    collect_directions(scene);
    scene.fixed = read_fixed(root);
    scene.membranes = read_membranes(root);
    scene.beds = read_beds(root);
    scene.gravity = read_gravity(root);
    scene.free_body = read_free_body(root, scene.gravity);
    scene.relaxation = read_relaxation(root);
    scene.touch = read_touch(root);
    scene.contact = read_contact(root, scene.free_body.has_value());
    const Section device = root.section(
        "device",
        {"model",     "max_force", "mass",           "damping",    "friction",        "encoder_step", "bandwidth",
         "delay",     "position",  "rotation",       "handedness", "motion_scale",    "force_scale",  "clutch_ramp",
         "workspace", "max_speed", "max_force_rate", "mean_force", "mean_force_time", "force_return", "ramp_time"},
        false);
    scene.device = read_device(device);
    scene.device_map = read_device_map(device);
    scene.device.limits.grab = scene.contact.grab;
    scene.tables = read_table_options(root, scene.contact);
    scene.device.limits.check = scene.tables.check;
    scene.vibration = read_vibration(root, scene);
    return scene;
}

}  // namespace haptable
