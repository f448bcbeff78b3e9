// SPDX-License-Identifier: GPL-2.0-or-later
// Tetrahedra that are almost flat.
#include "tests/hard/holds.hpp"

namespace haptable::test {
namespace {

TEST(HardSliver, RadiusRatioOfAMillionth) { expect_holds("slivers of radius ratio 1e-6"); }

}  // namespace
}  // namespace haptable::test
