// SPDX-License-Identifier: GPL-2.0-or-later
// What haptable made may be written over and removed; nothing else, whatever the folder is called or linked to.
#include "host/base/own_folder.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "tests/error_of.hpp"
#include "tests/process.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable {
namespace {

namespace fs = std::filesystem;

class BaseOwnFolder : public testing::Test {
protected:
    std::string refusal(const std::string& holds = kSession) const {
        return test::error_of([&] { const OwnFolder folder(place_, holds); });
    }
    std::size_t count(const fs::path& folder) const {
        return std::size_t(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
    }
    /// As a run that wrote two files.
    void write() const {
        OwnFolder own(place_, kSession);
        write_file(own.file("a"), "a");
        write_file(own.file("b"), "b");
    }

    const test::TemporaryFolder temporary_;
    const fs::path place_ = temporary_.path() / "out";
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
    const fs::path victim = temporary_.path() / "victim";
    for (const char* text : {"", "haptable session\na\n"}) {
        write_file(victim, text);
        fs::remove(place_ / ".haptable");
        fs::create_symlink(victim, place_ / ".haptable");
        EXPECT_TRUE(test::says(refusal(), "its .haptable is a link"));
        EXPECT_EQ(read_file(victim), text);
    }
}

TEST_F(BaseOwnFolder, NamesInAMarkStayInTheFolder) {
    write_file(temporary_.path() / "victim", "kept");
    fs::create_directories(place_);
    write_file(place_ / ".haptable",
               "haptable session\n../victim\n..\n" + (temporary_.path() / "victim").string() + "\n");
    { OwnFolder(place_, kSession).clear(); }
    EXPECT_EQ(read_file(temporary_.path() / "victim"), "kept");
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
    write_file(temporary_.path() / "victim", "kept");
    fs::create_symlink(temporary_.path() / "victim", place_ / ("a.haptable-" + std::to_string(getpid())));
    EXPECT_THROW(write_file(place_ / "a", "x"), Error);
    EXPECT_EQ(read_file(temporary_.path() / "victim"), "kept");
}

}  // namespace
}  // namespace haptable
