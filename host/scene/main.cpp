// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-keys: the table of a scene's keys as JSON; lab/scene_keys.py makes page and schema of it (make scene-keys).
#include <fmt/format.h>

#include "host/base/json.hpp"
#include "host/base/program.hpp"
#include "host/scene/keys.hpp"
#include "host/scene/read_options.hpp"

namespace {

using namespace haptable;
using Json = nlohmann::ordered_json;

// In the order of KeyType and of Rule::Kind.
constexpr const char* kTypes[] = {"number", "integer",   "flag", "text",  "word",   "three", "one-or-three",
                                  "six",    "direction", "box",  "nodes", "points", "by-law"};
constexpr const char* kKinds[] = {"needs", "excludes", "one-of"};

/// Without an end: null.
Json to_json(const Range& range) {
    return {{"least", range.least == -Range::kNone ? Json() : Json(range.least)},
            {"most", range.most == Range::kNone ? Json() : Json(range.most)},
            {"above", range.above},
            {"below", range.below}};
}

Json to_json(const Key& key) {
    Json json{{"section", key.section},
              {"name", key.name},
              {"type", kTypes[static_cast<std::size_t>(key.type)]},
              {"unit", key.unit},
              {"words", key.words},
              {"fallback", key.fallback},
              {"fallback_text", key.fallback_text},
              {"required", key.required},
              {"means", key.means}};
    json.update(to_json(key.range));
    return json;
}

void print_keys() {
    Json all{{"defaults", default_options().values()}, {"modulus", to_json(kModulus)}};
    for (const SectionKey& section : scene_sections())
        all["sections"].push_back({{"name", section.name},
                                   {"is_list", section.is_list},
                                   {"required", section.required},
                                   {"means", section.means}});
    for (const Key& key : scene_keys()) all["keys"].push_back(to_json(key));
    for (const Rule& rule : scene_rules())
        all["rules"].push_back(
            {{"kind", kKinds[rule.kind]}, {"subject", rule.subject}, {"other", rule.other}, {"at", rule.at}});
    fmt::print("{}\n", json_text(all, 1));
}

}  // namespace

int main(int argc, char** argv) {
    haptable::CommandLine app("Prints the keys of a scene as JSON.", "haptable-keys");
    return haptable::run_program(app, argc, argv, [] { print_keys(); });
}
