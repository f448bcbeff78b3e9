// SPDX-License-Identifier: GPL-2.0-or-later
// Every element with every law and every force, in a skin, on a bed, under its weight, relaxing, of two materials.
#include <gtest/gtest.h>

#include <tuple>

#include "codegen/in_memory.hpp"
#include "host/base/file.hpp"
#include "host/body/assembly.hpp"
#include "host/body/gravity.hpp"
#include "host/inverse/factor.hpp"
#include "host/precompute/precompute.hpp"
#include "tests/bodies.hpp"
#include "tests/conditioning.hpp"
#include "tests/dense.hpp"
#include "tests/error_of.hpp"
#include "tests/finger.hpp"
#include "tests/host/body/cubes.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

using Combination = std::tuple<Element, Law, ForceLaw>;

Scene scene_of(const Combination& combination) {
    const auto& [element, law, force] = combination;
    Scene scene = layered_cube(element, law);
    scene.relaxation = {{0.3, 0.5}};
    scene.contact.force = force;
    if (force == ForceLaw::kPressureMask) scene.contact.mask_radius_m = 0.012;
    return scene;
}

class Combinations : public testing::TestWithParam<Combination> {
protected:
    Result run(const Scene& scene) const {
        Progress progress(true);
        return precompute(scene, folder_.path() / "out", progress, {});
    }
    std::string bytes(const char* file) const { return read_file(folder_.path() / "out" / file); }
    const TemporaryFolder folder_;
};

// L of the body with its stress, by a dense inverse, where a node is touched.
void expect_inverse(const Scene& scene, const Body& body, const Tables& tables) {
    const Factor without(assemble_free(scene, body));
    const Stiffness k = assemble_free(scene, body, prestress_of(scene, body, find_sag(scene, body, without)));
    const Eigen::MatrixXd l = dense::inverse_spd(Eigen::MatrixXd(assembled(k)));
    const Bound bound = inverse_bound(k).times(10.0);
    for (std::size_t i = 0; i < tables.node_id.size(); ++i) {
        const Eigen::Index row = 3 * Eigen::Index{body.unknown[std::size_t(tables.node_id[i])]};
        const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> s(tables.stiffness[i].data());
        const Eigen::Matrix3d l_ii = l.block<3, 3>(row, row);
        ASSERT_WITHIN((s * l_ii - Eigen::Matrix3d::Identity()).norm(), bound.times(s.norm() * l_ii.norm()))
            << "node " << tables.node_id[i];
    }
}

// Pressed and held, it is felt, and gives way: but for what goes in the 30 ms of the press.
void expect_felt(const Tables& tables) {
    const ServoModel servo = build_model(tables);
    const haptable_model model = model_in_memory(tables, servo);
    Tables elastic = tables;
    elastic.relaxation.clear();
    EXPECT_EQ(servo.stiffness.felt_n_per_m, build_model(elastic).stiffness.felt_n_per_m) << "at once it is as stiff";
    Finger finger(model);
    finger.to({0.0145, 0.0162, 0.031});
    for (int tick = 0; tick <= 30; ++tick) finger.to({0.0145, 0.0162, 0.031 - 1e-4 * tick});
    const double at_once_n = finger.force().z();
    EXPECT_GT(at_once_n, 0.05);
    for (int tick = 0; tick < 3000; ++tick) finger.to({0.0145, 0.0162, 0.028});
    EXPECT_NEAR(finger.force().z() / at_once_n, 1.0 - 0.3, 0.3 * 0.03 / 0.5);
}

TEST_P(Combinations, TablesAreTheInverseOfAllOfKAndAreFeltAndKept) {
    const Scene scene = scene_of(GetParam());
    const Body body = run(scene).body;
    Tables tables = read_tables(folder_.path() / "out");
    expect_inverse(scene, body, tables);
    tables.limits = {};
    for (const GodObject god_object : every<GodObject>()) {
        tables.god_object = god_object;
        expect_felt(tables);
    }
    for (const char* field : {"membrane", "bed", "sag"})
        EXPECT_TRUE(says(bytes("mesh.vtu"), "Name=\"" + std::string(field) + "\"")) << field;
    const bool has_axes = bytes("mesh.vtu").find("material_axis_3") != std::string::npos;
    EXPECT_EQ(has_axes, std::get<1>(GetParam()) != Law::kIsotropic);
    EXPECT_TRUE(run(scene).unchanged);
}

INSTANTIATE_TEST_SUITE_P(All, Combinations,
                         testing::Combine(testing::ValuesIn(kElements), testing::ValuesIn(kLaws),
                                          testing::ValuesIn(every<ForceLaw>())));

}  // namespace
}  // namespace haptable::test
