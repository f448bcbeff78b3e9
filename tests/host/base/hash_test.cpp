// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/hash.hpp"

#include <gtest/gtest.h>

#include "host/base/file.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

TEST(Hash, IsXxh3) { EXPECT_EQ(Hash().text(), "2d06800538d394c2"); }

TEST(Hash, TellsListsApartThatHoldTheSameValues) {
    Hash one, other;
    for (const char* word : {"ab", "c"}) one.add(std::string(word));
    for (const char* word : {"a", "bc"}) other.add(std::string(word));
    EXPECT_NE(one.digest(), other.digest());
}

TEST(Hash, OfAFileIsThatOfItsBytes) {
    const TemporaryFolder folder;
    const std::string text(3'000'000, 'x');  // more than is read at a time
    write_file(folder.path() / "file", text);
    Hash hash;
    hash.add_bytes(std::as_bytes(std::span(text)));
    EXPECT_EQ(hash_file(folder.path() / "file"), hash.text());
    EXPECT_EQ(hash_file(folder.path() / "none"), "");
}

}  // namespace
}  // namespace haptable::test
