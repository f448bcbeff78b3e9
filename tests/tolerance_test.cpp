// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/tolerance.hpp"

#include <gtest/gtest-spi.h>

#include <limits>

namespace haptable::test {
namespace {

TEST(Within, ABoundIsTheProductOfItsTerms) {
    EXPECT_WITHIN(23.9, .count = 2, .epsilon = 3.0, .condition = 4.0);
    EXPECT_WITHIN(-1.0, .epsilon = 0.0) << "an exact limit that is kept";
    EXPECT_EQ((Bound{.count = 2.0, .epsilon = 3.0, .condition = 4.0}.times(5.0).value()), 120.0);
}

TEST(Within, AFailureTellsHowFarOverTheBoundItIs) {
    EXPECT_NONFATAL_FAILURE(EXPECT_WITHIN(3.0, .count = 2, .epsilon = 0.5), "is 3, 3 times its bound 1");
    EXPECT_NONFATAL_FAILURE(EXPECT_WITHIN(3.0, .count = 2, .epsilon = 0.5), "count 2 x epsilon 0.5 x condition 1");
}

TEST(Within, WhatIsNotANumberFails) {
    EXPECT_NONFATAL_FAILURE(EXPECT_WITHIN(std::numeric_limits<double>::quiet_NaN(), .epsilon = 1.0), "nan");
}

}  // namespace
}  // namespace haptable::test
