// SPDX-License-Identifier: GPL-2.0-or-later
// Many tetrahedra and many patches at one node.
#include "tests/hard/holds.hpp"

namespace haptable::test {
namespace {

TEST(HardHub, EightyTetrahedraAtANode) { expect_holds("80 tetrahedra at a node"); }

TEST(HardHub, ThirtyTwoPatchesAtANode) { expect_holds("32 patches at a node"); }

TEST(HardHub, MorePatchesThanATickCanGoAroundAreRefused) {
    expect_refused("60 patches at a node", "60 touchable patches meet at node");
}

}  // namespace
}  // namespace haptable::test
