// SPDX-License-Identifier: GPL-2.0-or-later
// Far from the origin.
#include "tests/hard/holds.hpp"

namespace haptable::test {
namespace {

// As far as the coordinates are taken as they are, and farther, where the body is moved.
TEST(HardFar, FromTheOrigin) {
    expect_holds("900 diagonals from the origin");
    expect_holds("1e6 diagonals from the origin");
}

}  // namespace
}  // namespace haptable::test
