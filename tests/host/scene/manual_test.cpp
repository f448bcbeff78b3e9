// SPDX-License-Identifier: GPL-2.0-or-later
// The page, the schema and the program tell the same of every key.
#include "host/scene/manual.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "host/base/file.hpp"
#include "host/base/json.hpp"
#include "host/scene/keys.hpp"
#include "host/scene/read_options.hpp"
#include "tests/error_of.hpp"

namespace haptable {
namespace {

constexpr const char* kAnew = "differs from host/scene/keys.cpp: make scene-keys writes it anew";

TEST(SceneKeys, ThePageHasThemAll) {
    const std::string page = read_file("docs/SCENE.md");
    EXPECT_EQ(with_keys(page), page) << kAnew;
    for (const Key& key : scene_keys()) EXPECT_NE(page.find(key.name), std::string::npos) << key.name;
    for (const SectionKey& section : scene_sections()) EXPECT_NE(page.find(section.name), std::string::npos);
    for (const char* key : {"[body] suspension_damping", "[tables] coupling_bytes"})
        EXPECT_NE(page.find("| `" + std::string(key) + "` |"), std::string::npos) << key;
}

TEST(SceneKeys, APageIsMadeAnewBetweenItsMarks) {
    const std::string page = with_keys("a\n<!-- keys: tables -->\nold\n<!-- end -->\nb\n");
    EXPECT_EQ(page.find("old"), std::string::npos);
    EXPECT_TRUE(page.starts_with("a\n<!-- keys: tables -->\n\n| key |")) << page;
    EXPECT_TRUE(page.ends_with("|\n\n<!-- end -->\nb\n")) << page;
    EXPECT_EQ(test::error_of([] { with_keys("<!-- keys: tables -->\n"); }), "a table of keys has no \"<!-- end -->\"");
    EXPECT_EQ(test::error_of([] { with_keys("<!-- keys: table -->\n<!-- end -->"); }),
              "there is no section table in a scene");
}

TEST(SceneKeys, TheSchemaHasThemAll) {
    EXPECT_EQ(scene_schema(), read_file("docs/scene.schema.json")) << kAnew;
    const nlohmann::json schema = parse_json(scene_schema());
    for (const Key& key : scene_keys()) {
        nlohmann::json table = schema;
        if (*key.section != '\0') table = table["properties"][key.section];
        if (table.contains("items")) table = table["items"];
        EXPECT_FALSE(table["properties"][key.name].value("description", "").empty()) << key.section << " " << key.name;
    }
}

// A rule that speaks of a key that there is not would never hold.
TEST(SceneKeys, RulesSpeakOfKeysThatThereAre) {
    const auto is_known = [](std::string_view condition) {
        const std::size_t end = condition.find_first_of("=>"), point = condition.find('.');
        if (point == std::string_view::npos)
            return std::any_of(scene_sections().begin(), scene_sections().end(),
                               [&](const SectionKey& section) { return condition == section.name; });
        const auto keys = keys_of(condition.substr(0, point));
        return std::any_of(keys.begin(), keys.end(), [&](const Key* key) {
            return condition.substr(point + 1, end == std::string_view::npos ? end : end - point - 1) == key->name;
        });
    };
    for (const Rule& rule : scene_rules()) {
        EXPECT_TRUE(is_known(rule.subject)) << rule.subject;
        EXPECT_TRUE(*rule.at == '\0' || is_known(rule.at)) << rule.at;
        std::string_view others = rule.other;
        for (std::size_t end = 0; end != std::string_view::npos;) {
            end = others.find('|');
            EXPECT_TRUE(is_known(others.substr(0, end))) << rule.other;
            if (end != std::string_view::npos) others.remove_prefix(end + 1);
        }
    }
}

// A default that the range refuses could not be written into a scene.
TEST(SceneKeys, DefaultsAreInTheirRange) {
    const SceneOptions defaults = default_options();
    for (const Key& key : scene_keys()) {
        const std::string name = std::string(key.section) + "." + key.name;
        if (key.type != KeyType::kNumber || !defaults.has(name) || !defaults.at(name).is_number()) continue;
        const double value = defaults.number(name);
        EXPECT_TRUE(value >= key.range.least && value <= key.range.most) << name << " " << value;
    }
}

}  // namespace
}  // namespace haptable
