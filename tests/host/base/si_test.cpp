// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/si.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace haptable::test {
namespace {

TEST(Si, GivesThreeDigitsAndAPrefix) {
    EXPECT_EQ(si(0.00116, "N"), "1.16 mN");
    EXPECT_EQ(si(1.2, "N"), "1.20 N");
    EXPECT_EQ(si(-0.0345678, "N"), "-34.6 mN");
    EXPECT_EQ(si(123.4, "N"), "123 N");
    EXPECT_EQ(si(5e-6, "m"), "5.00 um");
    EXPECT_EQ(si(2.0e7, "Pa"), "20.0 MPa");
    EXPECT_EQ(si(0.0, "N"), "0 N");
}

// What rounds up to a thousand takes the next prefix.
TEST(Si, RoundsBeforeItChoosesThePrefix) {
    EXPECT_EQ(si(0.0009996, "N"), "1.00 mN");
    EXPECT_EQ(si(0.9999, "N"), "1.00 N");
    EXPECT_EQ(si(0.9994, "N"), "999 mN");
}

TEST(Si, HoldsWhatIsBeyondItsPrefixes) {
    EXPECT_EQ(si(3e-13, "N"), "0.000300 nN");
    EXPECT_EQ(si(std::numeric_limits<double>::infinity(), "N"), "inf N");
}

}  // namespace
}  // namespace haptable::test
