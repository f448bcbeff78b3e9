// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "host/base/error.hpp"
#include "tests/error_of.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable {
namespace {

namespace fs = std::filesystem;

class BaseFile : public testing::Test {
protected:
    std::size_t count() const {
        return std::size_t(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
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
    EXPECT_EQ(count(), 1U) << "something was left beside the file";
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
        EXPECT_EQ(count(), 1U);
    }
}

TEST_F(BaseFile, ALinkStaysALink) {
    write_file(folder_ / "a", "old");
    fs::create_symlink("a", folder_ / "link");
    write_file(folder_ / "link", "new");
    EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
    EXPECT_EQ(read_file(folder_ / "a"), "new");
    EXPECT_EQ(count(), 2U);
}

// A pipe stands for all that is no file: nobody wants to lose /dev/null in a test.
TEST_F(BaseFile, ADeviceOrPipeIsNotReplaced) {
    ASSERT_EQ(mkfifo((folder_ / "pipe").c_str(), 0600), 0);
    EXPECT_THROW(write_file(folder_ / "pipe", "x"), Error);
    EXPECT_TRUE(fs::is_fifo(folder_ / "pipe"));
    EXPECT_EQ(count(), 1U);
}

}  // namespace
}  // namespace haptable
