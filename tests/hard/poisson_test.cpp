// SPDX-License-Identifier: GPL-2.0-or-later
// Poisson's ratio at the ends of what is allowed.
#include "tests/hard/holds.hpp"

namespace haptable::test {
namespace {

TEST(HardPoisson, Zero) {
    expect_holds("Poisson's ratio 0");
    expect_holds("Poisson's ratio 0, average nodal pressure");
}

TEST(HardPoisson, NearOneHalf) {
    expect_holds("Poisson's ratio 0.4999");
    expect_holds("Poisson's ratio 0.4999, average nodal pressure");
}

}  // namespace
}  // namespace haptable::test
