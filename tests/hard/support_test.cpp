// SPDX-License-Identifier: GPL-2.0-or-later
// Held almost nowhere, almost everywhere, and not enough.
#include "tests/hard/holds.hpp"

namespace haptable::test {
namespace {

TEST(HardSupport, ThreeNodes) { expect_holds("held at three nodes"); }

TEST(HardSupport, AllNodesButOne) { expect_holds("held at all nodes but one"); }

// By the mesh alone: the pivots of K would tell too, but only after it was factorised, and "to rounding".
TEST(HardSupport, OneNodeOrNoneIsRefused) {
    expect_refused("held at one node", "fixed: 124 of 125 nodes are under-constrained");
    expect_refused("free", "fixed: 125 of 125 nodes are under-constrained");
}

}  // namespace
}  // namespace haptable::test
