// SPDX-License-Identifier: GPL-2.0-or-later
// Every key that a scene file may have, once: its reader, its errors, options.json, what is hashed, docs/SCENE.md and
// docs/scene.schema.json all follow this table.
#pragma once

#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/base/scene_options.hpp"

namespace haptable {

enum class KeyType {
    kNumber,  ///< or one of its words, where it has some
    kInteger,
    kFlag,
    kText,        ///< not empty
    kWord,        ///< one of its words
    kThree,       ///< x y z
    kOneOrThree,  ///< a number, for all three, or three
    kSix,         ///< along x y z, then about them
    kDirection,   ///< three numbers that are not all 0
    kBox,         ///< xmin ymin zmin xmax ymax zmax
    kNodes,       ///< mesh nodes, each once
    kPoints,      ///< a number of points, or a list of points, [x, y, z] each
    kByLaw        ///< a material's: its law says what it is (read_material.hpp)
};

struct Range {
    static constexpr double kNone = std::numeric_limits<double>::infinity();
    double least = -kNone, most = kNone;
    bool above = false;  ///< more than least
    bool below = false;  ///< less than most
};
/// Pa: diamond has 1.2e12; beyond these bounds the tables leave the range of float32.
constexpr Range kModulus{.least = 1e-3, .most = 1e15};
constexpr Range kPositive{.least = 0.0, .above = true}, kNotNegative{.least = 0.0};

/// What changes with a key, beyond what the mesh shows that it chooses.
enum class Changes {
    kNothing,  ///< no number of the tables: names, files, budgets, the simulated device
    kTables
};

struct Key {
    const char* section = "";  ///< empty: the scene itself
    const char* name = "";
    KeyType type = KeyType::kNumber;
    const char* unit = "";
    Range range = {};
    std::vector<const char*> words = {};
    nlohmann::ordered_json fallback = {};                                  ///< null: none
    nlohmann::ordered_json (*fallback_of)(const SceneOptions&) = nullptr;  ///< or by the keys above it
    const char* fallback_text = "";                                        ///< for people, where neither tells it
    bool required = false;
    const char* beyond = "";  ///< an error's text outside of the range, {} the value; empty: the range tells it
    Changes changes = Changes::kNothing;
    const char* means = "";  ///< a line for docs/SCENE.md and editors
};

struct SectionKey {
    const char* name;
    bool is_list = false;  ///< [[name]]
    bool required = false;
    bool is_optional = false;  ///< left out, it has no defaults
    const char* means;
};

/// Between keys. A condition is "section" or "section.key" (the scene gives it), "section.key=value" or
/// "section.key>0"; alternatives stand between |.
struct Rule {
    enum Kind { kNeeds, kExcludes, kOneOf } kind;
    const char* subject;
    const char* other;
    const char* error;    ///< what is wrong and what to do
    const char* at = "";  ///< the key that the error names; empty: the subject's
};

/// In the order in which they are read.
const std::vector<SectionKey>& scene_sections();
const std::vector<Key>& scene_keys();
const std::vector<Rule>& scene_rules();

/// Those of a section, in order.
std::vector<const Key*> keys_of(std::string_view section);

/// The default of a key with those above it, null where it has none.
nlohmann::ordered_json fallback_of(const Key& key, const SceneOptions& above);

/// Those values of `options` that change the tables, as text: what is hashed.
std::string text_of_tables(const SceneOptions& options);

}  // namespace haptable
