// SPDX-License-Identifier: GPL-2.0-or-later
// Two materials a million times apart.
#include "tests/hard/holds.hpp"

namespace haptable::test {
namespace {

TEST(HardMaterials, StiffOverSoft) { expect_holds("1e9 Pa over 1e3 Pa"); }

TEST(HardMaterials, SoftOverStiff) { expect_holds("1e3 Pa over 1e9 Pa"); }

}  // namespace
}  // namespace haptable::test
