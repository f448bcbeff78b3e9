// SPDX-License-Identifier: GPL-2.0-or-later
// Held almost nowhere, almost everywhere, and not enough.
#include "tests/hard/holds.hpp"

namespace haptable::test {
namespace {

TEST(HardSupport, ThreeNodes) { expect_holds("held at three nodes"); }

TEST(HardSupport, AllNodesButOne) { expect_holds("held at all nodes but one"); }

TEST(HardSupport, OneNodeOrNoneIsRefused) {
    expect_refused("held at one node", "under-constrained");
    expect_refused("free", "under-constrained");
}

}  // namespace
}  // namespace haptable::test
