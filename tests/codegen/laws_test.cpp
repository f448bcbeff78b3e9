// SPDX-License-Identifier: GPL-2.0-or-later
// host/base/laws.inc is the one list of force laws and god-objects, HAPTABLE_MOVERS that of movers: the pages' tables
// have the same.
#include <gtest/gtest.h>

#include <regex>
#include <string>
#include <vector>

#include "codegen/laws.hpp"
#include "firmware/haptable_scene.h"
#include "host/base/file.hpp"
#include "host/base/modes.hpp"
#include "host/scene/keys.hpp"
#include "tests/error_of.hpp"

namespace haptable::test {
namespace {

/// The words in quotes that the second column of a page's table has, from the row of `key` up to the next key's.
std::vector<std::string> words_of(const std::string& page, const std::string& key) {
    const std::size_t begin = page.find("| `" + key + "` |");
    const std::string rows = page.substr(begin, page.find("\n| `", begin + 1) - begin);
    std::vector<std::string> found;
    const std::regex row("\\|[^|\n]*\\| `\"([a-z-]+)\"`");
    for (std::sregex_iterator at(rows.begin(), rows.end(), row), end; at != end; ++at) found.push_back((*at)[1]);
    return found;
}

template <typename Choice>
std::vector<std::string> listed() {
    const auto all = words(Choice{});
    return {all.begin(), all.end()};
}

TEST(Laws, ThePageOfContactHasEachInTheListsOrder) {
    const std::string page = read_file("docs/CONTACT.md");
    EXPECT_EQ(words_of(page, "force"), listed<ForceLaw>());
    EXPECT_EQ(words_of(page, "god_object"), listed<GodObject>());
}

TEST(Laws, ThePageOfWhatMovesHasEachMover) {
    const std::string page = read_file("docs/MOVING.md");
    const std::string table = page.substr(page.find("\n|"), page.find("\n\n", page.find("\n|")) - page.find("\n|"));
    for (const char* title : {
#define HAPTABLE_TITLE(PART, KEY, WORD, TITLE, ...) TITLE,
             HAPTABLE_MOVERS(HAPTABLE_TITLE)})
        EXPECT_TRUE(says(table, title)) << "docs/MOVING.md, its first table: " << title;
}

/// True for a key of a scene that changes the tables.
bool changes_tables(const std::string& key) {
    for (const Key& one : scene_keys())
        if (key == std::string(one.section) + "." + one.name) return one.changes == Changes::kTables;
    return false;
}

TEST(Laws, KeysThatTheFirmwareNamesAreAScenes) {
    for (const char* key : {
#define HAPTABLE_MOVER_KEY(PART, KEY, ...) KEY,
#define HAPTABLE_VALUE_KEY(FIELD, KEY) KEY,
#define HAPTABLE_STAGE_KEY(FIELD, FUNCTION, KEY) KEY,
             HAPTABLE_MOVERS(HAPTABLE_MOVER_KEY) HAPTABLE_MODEL_KEYS(HAPTABLE_VALUE_KEY, HAPTABLE_STAGE_KEY)})
        EXPECT_TRUE(changes_tables(key)) << key;
}

}  // namespace
}  // namespace haptable::test
