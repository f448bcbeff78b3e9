// SPDX-License-Identifier: GPL-2.0-or-later
// Needles and plates, along the axes and askew.
#include "tests/hard/holds.hpp"

namespace haptable::test {
namespace {

TEST(HardSlender, Needle) {
    expect_holds("needle 1:100");
    expect_holds("needle 1:100, askew");
    expect_holds("needle 1:100 of steel, askew");
}

TEST(HardSlender, Plate) {
    expect_holds("plate 1:100");
    expect_holds("plate 1:100, askew");
}

}  // namespace
}  // namespace haptable::test
