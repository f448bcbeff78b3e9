// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/si.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

namespace haptable::test {
namespace {

TEST(Si, GivesThreeDigitsAndAPrefix) {
    for (const auto& [value, unit, said] : {std::tuple(0.00116, "N", "1.16 mN"),
                                            {1.2, "N", "1.20 N"},
                                            {-0.0345678, "N", "-34.6 mN"},
                                            {123.4, "N", "123 N"},
                                            {5e-6, "m", "5.00 um"},
                                            {2.0e7, "Pa", "20.0 MPa"},
                                            {0.0, "N", "0 N"},
                                            // What rounds up to a thousand takes the next prefix.
                                            {0.0009996, "N", "1.00 mN"},
                                            {0.9999, "N", "1.00 N"},
                                            {0.9994, "N", "999 mN"},
                                            // Beyond its prefixes.
                                            {3e-13, "N", "0.000300 nN"},
                                            {HUGE_VAL, "N", "inf N"}})
        EXPECT_EQ(si(value, unit), said);
}

}  // namespace
}  // namespace haptable::test
