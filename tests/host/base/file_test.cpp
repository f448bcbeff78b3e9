// SPDX-License-Identifier: GPL-2.0-or-later
// Files, their hashes, and folders of haptable's own.
#include "host/base/file.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>

#include "host/base/error.hpp"
#include "host/base/hash.hpp"
#include "host/base/own_folder.hpp"
#include "tests/error_of.hpp"
#include "tests/process.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable {
namespace {

namespace fs = std::filesystem;

class BaseFile : public testing::Test {
protected:
    static std::size_t count(const fs::path& folder) {
        return std::size_t(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
    }

    const test::TemporaryFolder temporary_;
    const fs::path folder_ = temporary_.path();
};

TEST_F(BaseFile, WhatIsWrittenIsRead) {
    const std::string bytes("a\0b\r\n\xFF", 6);
    write_file(folder_ / "a", bytes);
    EXPECT_EQ(read_file(folder_ / "a"), bytes);
    write_file(folder_ / "a", "");
    EXPECT_EQ(read_file(folder_ / "a"), "");
    EXPECT_EQ(count(folder_), 1U) << "something was left beside the file";
}

TEST_F(BaseFile, TextIsReadWithoutItsMark) {
    const std::string mark = "\xEF\xBB\xBF";
    write_file(folder_ / "a", mark + "x" + mark);
    EXPECT_EQ(read_text(folder_ / "a"), "x" + mark) << "only the first is a mark";
    EXPECT_EQ(read_file(folder_ / "a"), mark + "x" + mark);
    for (const std::string& utf16 : {std::string("\xFF\xFEx\0", 4), std::string("\xFE\xFF\0x", 4)}) {
        write_file(folder_ / "a", utf16);
        EXPECT_TRUE(test::fails_with([&] { read_text(folder_ / "a"); }, "a: is text in UTF-16"));
    }
}

TEST_F(BaseFile, ErrorsNameThePath) {
    for (const fs::path& path : {folder_ / "missing", folder_}) {
        const std::string said = test::error_of([&] { read_file(path); });
        EXPECT_EQ(said.rfind(path.string(), 0), 0U) << said;
    }
    EXPECT_THROW(write_file(folder_ / "no" / "such" / "folder", "x"), Error);
}

TEST_F(BaseFile, CommitReplacesAndWithoutItNothingIsLeft) {
    write_file(folder_ / "a", "old");
    for (const auto& [is_committed, after] : {std::pair(false, "old"), {true, "new"}}) {
        {
            StagedPath beside(folder_ / "a");
            write_file(beside.path(), "new");
            EXPECT_EQ(read_file(folder_ / "a"), "old");
            if (is_committed) beside.commit();
        }
        EXPECT_EQ(read_file(folder_ / "a"), after);
        EXPECT_EQ(count(folder_), 1U);
    }
}

TEST_F(BaseFile, ALinkStaysALink) {
    write_file(folder_ / "a", "old");
    fs::create_symlink("a", folder_ / "link");
    write_file(folder_ / "link", "new");
    EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
    EXPECT_EQ(read_file(folder_ / "a"), "new");
    EXPECT_EQ(count(folder_), 2U);
}

// A pipe stands for all that is no file: nobody wants to lose /dev/null in a test.
TEST_F(BaseFile, ADeviceOrPipeIsNotReplaced) {
    ASSERT_EQ(mkfifo((folder_ / "pipe").c_str(), 0600), 0);
    EXPECT_THROW(write_file(folder_ / "pipe", "x"), Error);
    EXPECT_TRUE(fs::is_fifo(folder_ / "pipe"));
    EXPECT_EQ(count(folder_), 1U);
}

TEST(Hash, IsXxh3) { EXPECT_EQ(Hash().text(), "2d06800538d394c2"); }

TEST(Hash, TellsListsApartThatHoldTheSameValues) {
    Hash one, other;
    for (const char* word : {"ab", "c"}) one.add(std::string(word));
    for (const char* word : {"a", "bc"}) other.add(std::string(word));
    EXPECT_NE(one.digest(), other.digest());
}

TEST_F(BaseFile, ItsHashIsThatOfItsBytes) {
    const std::string text(3'000'000, 'x');  // more than is read at a time
    write_file(folder_ / "file", text);
    Hash hash;
    hash.add_bytes(std::as_bytes(std::span(text)));
    EXPECT_EQ(hash_file(folder_ / "file"), hash.text());
    EXPECT_EQ(hash_file(folder_ / "none"), "");
}

// What haptable made may be written over and removed; nothing else, whatever the folder is called or linked to.
class BaseOwnFolder : public BaseFile {
protected:
    std::string refusal(const std::string& holds = kSession) const {
        return test::error_of([&] { const OwnFolder folder(place_, holds); });
    }
    /// As a run that wrote two files.
    void write() const {
        OwnFolder own(place_, kSession);
        write_file(own.file("a"), "a");
        write_file(own.file("b"), "b");
    }

    const fs::path place_ = folder_ / "out";
};

TEST_F(BaseOwnFolder, WhatHaptableMadeGoesAndNothingElse) {
    write();
    write_file(place_ / "notes", "the user's");
    OwnFolder own(place_, kSession);
    own.clear({"b"});
    EXPECT_FALSE(fs::exists(place_ / "a"));
    EXPECT_TRUE(fs::exists(place_ / "b") && fs::exists(place_ / "notes"));
    own.remove("notes");
    EXPECT_EQ(read_file(place_ / "notes"), "the user's");
    EXPECT_TRUE(test::fails_with([&] { own.file("notes"); }, "notes: is not haptable's"));
    EXPECT_NO_THROW(write_file(own.file("a"), "again"));
}

TEST_F(BaseOwnFolder, AFolderWithoutItsMarkIsLeftAsItIs) {
    write();
    EXPECT_TRUE(test::says(refusal(kTables), "holds haptable's session, not tables"));
    for (const auto& [mark, why] : {std::pair("", "holds files that haptable did not write"),  // it says nothing
                                    {"something else\n", "is not haptable's"}}) {
        write_file(place_ / ".haptable", mark);
        EXPECT_TRUE(test::says(refusal(), why));
        EXPECT_EQ(read_file(place_ / ".haptable"), mark);
    }
    fs::remove(place_ / ".haptable");
    EXPECT_TRUE(test::says(refusal(), "out: holds files that haptable did not write"));
    EXPECT_EQ(count(place_), 2U);
}

TEST_F(BaseOwnFolder, AMarkIsNeverWrittenThroughALink) {
    fs::create_directories(place_);
    const fs::path victim = folder_ / "victim";
    for (const char* text : {"", "haptable session\na\n"}) {
        write_file(victim, text);
        fs::remove(place_ / ".haptable");
        fs::create_symlink(victim, place_ / ".haptable");
        EXPECT_TRUE(test::says(refusal(), "its .haptable is a link"));
        EXPECT_EQ(read_file(victim), text);
    }
}

TEST_F(BaseOwnFolder, NamesInAMarkStayInTheFolder) {
    write_file(folder_ / "victim", "kept");
    fs::create_directories(place_);
    write_file(place_ / ".haptable", "haptable session\n../victim\n..\n" + (folder_ / "victim").string() + "\n");
    { OwnFolder(place_, kSession).clear(); }
    EXPECT_EQ(read_file(folder_ / "victim"), "kept");
}

// kill -9 at any moment: the lock goes with the process, the mark tells the next run what is haptable's.
TEST_F(BaseOwnFolder, WhatAKilledProcessLeftGoes) {
    const int status = test::status_of([this] {
        OwnFolder own(place_, kSession);
        write_file(own.file("a"), "a");
        const StagedPath beside(place_ / "tables", StagedKind::folder);
        write_file(beside.path() / "half", "half");
        const StagedPath file(place_ / "b");
        return kill(getpid(), SIGKILL);
    });
    EXPECT_EQ(status, -SIGKILL);
    EXPECT_EQ(count(place_), 4U) << "the mark, a, and two under construction";
    write_file(place_ / "b.haptable-x", "the user's");
    OwnFolder own(place_, kSession);
    EXPECT_EQ(count(place_), 3U);
    own.clear();
    EXPECT_EQ(count(place_), 2U);
    EXPECT_TRUE(fs::exists(place_ / "b.haptable-x"));
}

// What is under construction is locked: another process does not take it for a leftover.
TEST_F(BaseOwnFolder, WhatIsUnderConstructionStays) {
    fs::create_directories(place_);
    StagedPath one(place_ / "a"), two(place_ / "b", StagedKind::folder);
    const fs::path held = place_ / "c.haptable-1";
    write_file(held, "another's");
    const int file = open(held.c_str(), O_RDONLY | O_CLOEXEC);
    ASSERT_EQ(flock(file, LOCK_EX), 0);
    remove_leftovers(place_);
    EXPECT_EQ(count(place_), 3U);
    close(file);
    remove_leftovers(place_);
    EXPECT_EQ(count(place_), 2U);
    one.commit();
    two.commit();
    EXPECT_TRUE(fs::is_regular_file(place_ / "a") && fs::is_directory(place_ / "b"));
}

// A link of that name, which another user may have put there, is not followed.
TEST_F(BaseOwnFolder, WhatIsUnderConstructionIsNeverWrittenThroughALink) {
    fs::create_directories(place_);
    write_file(folder_ / "victim", "kept");
    fs::create_symlink(folder_ / "victim", place_ / ("a.haptable-" + std::to_string(getpid())));
    EXPECT_THROW(write_file(place_ / "a", "x"), Error);
    EXPECT_EQ(read_file(folder_ / "victim"), "kept");
}

}  // namespace
}  // namespace haptable
