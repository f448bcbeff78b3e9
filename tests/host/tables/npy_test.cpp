// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/tables/npy.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "tests/error_of.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable {
namespace {

namespace fs = std::filesystem;

class NpyFile : public testing::Test {
protected:
    void expect_error(const std::string& part) {
        const std::string said = test::error_of([&] { read_npy<float>(path_); });
        EXPECT_TRUE(test::says(said, part));
        EXPECT_TRUE(test::says(said, path_.string()));
        EXPECT_THROW(MappedNpy<float>{path_}, Error);
    }

    const test::TemporaryFolder temporary_;
    const fs::path folder_ = temporary_.path();
    const fs::path path_ = folder_ / "a.npy";
};

TEST_F(NpyFile, RoundTripKeepsShapeAndBits) {
    const std::vector<double> values{0.0, -0.0, 1.0 / 3.0, 1e-310, -1e300, 7.0};
    write_npy<double>(path_, {1, 2, 3}, values);
    const Array<double> read = read_npy<double>(path_);
    EXPECT_EQ(read.shape, (std::vector<std::size_t>{1, 2, 3}));
    EXPECT_EQ(0, std::memcmp(read.values.data(), values.data(), 6 * sizeof(double)));
    const MappedNpy<double> mapped(path_);
    EXPECT_EQ(0, std::memcmp(mapped.values().data(), values.data(), 6 * sizeof(double)));
}

TEST_F(NpyFile, PiecesGiveTheSameBytesAsTheWhole) {
    const std::vector<std::int32_t> values{1, 2, 3, 4};
    write_npy<std::int32_t>(path_, {4}, values);
    NpyWriter<std::int32_t> writer(folder_ / "b.npy", {4});
    writer.append(std::span(values).first(1));
    writer.append(std::span(values).subspan(1));
    writer.close();
    EXPECT_EQ(read_file(path_), read_file(folder_ / "b.npy"));
}

TEST_F(NpyFile, HeaderIsNumPys) {
    // Written by numpy.save, version 1.24, of numpy.zeros((2, 3), dtype='<f4') and numpy.zeros(0, dtype='<i4').
    write_npy<float>(path_, {2, 3}, std::vector<float>(6));
    std::string expected =
        std::string("\x93NUMPY\x01\x00v\x00", 10) + "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }";
    expected.resize(127, ' ');
    EXPECT_EQ(read_file(path_), expected + "\n" + std::string(24, '\0'));
    write_npy<std::int32_t>(path_, {0}, {});
    EXPECT_TRUE(test::says(read_file(path_), "'shape': (0,), }"));
    EXPECT_TRUE(read_npy<std::int32_t>(path_).values.empty());
}

TEST_F(NpyFile, WriterCountsItsValues) {
    NpyWriter<float> writer(path_, {2});
    writer.append(std::vector<float>(1));
    EXPECT_THROW(writer.close(), Error);
    EXPECT_THROW(writer.append(std::vector<float>(2)), Error);
}

TEST_F(NpyFile, DamagedFilesAreErrorsThatNameTheFile) {
    expect_error("cannot be read");
    write_npy<float>(path_, {2, 3}, std::vector<float>(6));
    const std::string good = read_file(path_);
    const auto changed = [&](const std::string& from, const std::string& to) { return test::replaced(good, from, to); };
    for (const auto& [bytes, part] :
         {std::pair<std::string, const char*>{"", "not a .npy file"},
          {"not numpy at all", "not a .npy file"},
          {good.substr(0, 40), "ends within its header"},
          {good.substr(0, good.size() - 1), "bytes where its shape needs"},
          {good + "x", "bytes where its shape needs"},
          {changed("<f4", "<f8"), "another type"},
          {changed("False", "True "), "another type"},
          {changed("(2, 3)", "(2, 4)"), "bytes where its shape needs"},
          {changed("(2, 3)", "(2, x)"), "damaged shape"},
          {changed("(2, 3), }", "(2, 3), !"), "damaged shape"},
          // A shape whose product overflows to 6 values must not pass.
          {changed("(2, 3), }               ", "(18446744073709551615, 6), }").substr(0, good.size()),
           "damaged shape"}}) {
        write_file(path_, bytes);
        expect_error(part);
    }
}

TEST_F(NpyFile, TheLongestHeaderIsReadWithoutDeepRecursion) {
    std::string text =
        std::string("\x93NUMPY\x01\x00\xF0\xFF", 10) + "{'descr': '<f4', 'fortran_order': False, 'shape': (1,), }";
    text.resize(10 + 0xFFF0, ' ');
    write_file(path_, text + std::string(4, '\0'));
    EXPECT_EQ(read_npy<float>(path_).shape, std::vector<std::size_t>{1});
}

}  // namespace
}  // namespace haptable
