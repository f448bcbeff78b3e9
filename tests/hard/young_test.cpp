// SPDX-License-Identifier: GPL-2.0-or-later
// Young's modulus of almost nothing and of steel.
#include "tests/hard/holds.hpp"

namespace haptable::test {
namespace {

TEST(HardYoung, OnePascal) { expect_holds("1 Pa"); }

TEST(HardYoung, Steel) { expect_holds("200 GPa"); }

}  // namespace
}  // namespace haptable::test
