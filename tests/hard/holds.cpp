// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/hard/holds.hpp"

#include "host/base/error.hpp"
#include "host/body/assembly.hpp"
#include "host/hard/measure.hpp"
#include "tests/conditioning.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {

namespace {

// A force is some 24 roundings of its terms; a god-object lies at a sum of three corners, found in float.
constexpr double kForceRoundings = 24.0, kPlaceRoundings = 8.0;
constexpr int kPatches = 60;

void expect_stiffness(const HardBody& body, const Reference& reference) {
    const Bound inverse = inverse_bound(assemble_free(body.hard().scene, body.body()));
    const StiffnessErrors s = compare_stiffness(body, reference);
    EXPECT_WITHIN(s.in_terms_of_l, inverse.times(3.0)) << "of a block's 3 diagonal entries";
    EXPECT_WITHIN(s.asymmetry, .epsilon = kDouble);
    EXPECT_GT(s.least_eigenvalue, 0.0);
    // What precompute prints is the condition, to a tenth of a digit.
    const Checks& checks = body.summary().inverse.checks;
    EXPECT_LT(std::abs(std::log10(checks.scaled_condition / reference.scaled_condition)), 0.1);
    EXPECT_WITHIN(std::abs(checks.largest_block_condition / s.condition - 1.0), .count = s.condition,
                  .epsilon = inverse.value());
}

void expect_force(const HardBody& body, const Reference& reference, GodObject god_object) {
    const ForceErrors force = compare_force(body, reference, god_object, kPatches);
    EXPECT_GT(force.touches, 0U);
    EXPECT_EQ(force.missed, 0U);
    EXPECT_WITHIN(force.rounding, .count = kForceRoundings, .epsilon = kFloat);
    EXPECT_WITHIN(force.misplaced, .count = kPlaceRoundings, .epsilon = kFloat);
    const double stated = digits_of(body.summary()).servo.worst;
    if (god_object == GodObject::kNearest) {  // whose finger presses as precompute's does
        EXPECT_LE(force.worst, 3.0 * stated) << "what precompute states holds of other points, too";
    }
    EXPECT_TRUE(force.worst <= kMostServoError || !body.warnings().empty())
        << "loses " << force.worst << " of the force, and precompute states " << stated;
}

}  // namespace

void expect_holds(const std::string& name) {
    SCOPED_TRACE(name);
    const TemporaryFolder folder;
    const HardCase hard = hard_case(name, folder.path());
    Reference reference;
    for (const ForceLaw force : {ForceLaw::kInterpolated, ForceLaw::kConsistent}) {
        SCOPED_TRACE(word(force));
        const HardBody body(hard, force, folder.path() / "out");
        if (reference.compliance.size() == 0) reference = solve_densely(hard.scene, body.body());
        ASSERT_TRUE(reference.compliance.allFinite());
        expect_stiffness(body, reference);
        for (const GodObject god_object : every<GodObject>()) {
            SCOPED_TRACE(word(god_object));
            expect_force(body, reference, god_object);
        }
    }
}

void expect_refused(const std::string& name, const std::string& what) {
    SCOPED_TRACE(name);
    const TemporaryFolder folder;
    const HardCase hard = hard_case(name, folder.path());
    try {
        const HardBody body(hard, ForceLaw::kInterpolated, folder.path() / "out");
        ADD_FAILURE() << "was computed";
    } catch (const Error& error) {
        const std::string said = error.what();
        EXPECT_NE(said.find(what), std::string::npos) << said;
        EXPECT_EQ(said.find('\n'), std::string::npos) << said;
    }
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "out"));
}

}  // namespace haptable::test
