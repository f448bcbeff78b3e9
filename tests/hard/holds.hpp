// SPDX-License-Identifier: GPL-2.0-or-later
// What must hold of every hard case that is computed.
#pragma once

#include <gtest/gtest.h>

#include <string>

namespace haptable::test {

/// Through scene, tables and the servo in float32, for the interpolated and the consistent force, both god-objects:
/// - every S is symmetric, positive definite, and the reference's within the bound of its condition;
/// - a finger that goes into a patch is felt, with the reference's force within the bound of S's condition;
/// - where that is more than 1e-3 off, precompute has said so, and only there.
/// The reference is dense, in long double, from the elements' energies.
void expect_holds(const std::string& name);

/// Refused in one line that says `what`, and nothing is written.
void expect_refused(const std::string& name, const std::string& what);

}  // namespace haptable::test
