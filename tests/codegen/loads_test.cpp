// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/loads.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/bodies.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

/// One contact on the cube's top, and what the servo publishes of it.
struct Press {
    explicit Press(const ElasticBody& on) : body(on) {
        patch = body.patch_over(0.0131, 0.0172, alpha);
        god_m = body.point(patch, alpha);
        finger_m = (god_m + Vector3d(0.0006, -0.0003, -0.002)).cast<float>().cast<double>();
        const haptable_contact contact = contact_at(body, patch, alpha);
        const haptable_model model = body.model();
        const Eigen::Vector3f x = finger_m.cast<float>();
        float nodal_n[3][3], force_n[3];
        model.force(&model, &contact, x.data(), nodal_n, force_n);
        for (int c = 0; c < 3; ++c) {
            node[std::size_t(c)] = body.servo().node[body.vertex(patch, c)];
            published.push_back({node[std::size_t(c)], {nodal_n[c][0], nodal_n[c][1], nodal_n[c][2]}});
        }
        u_m = finger_m - Eigen::Map<const Eigen::Vector3f>(contact.god_object_m).cast<double>();
    }

    /// What the load does to the point that it presses on: sum w_a u_a, by L from solves.
    Vector3d moves(const std::vector<NodalForce>& loads) const {
        const std::vector<std::int32_t>& id = body.tables().node_id;
        Eigen::VectorXd force = Eigen::VectorXd::Zero(body.compliance().cols());
        for (const NodalForce& load : loads) {
            const auto at = std::lower_bound(id.begin(), id.end(), load.node) - id.begin();
            for (int c = 0; c < 3; ++c) force[3 * at + c] += double(load.force_n[std::size_t(c)]);
        }
        const Eigen::VectorXd displacement = body.compliance() * force;
        const Eigen::VectorXd w = body.weights(patch, alpha);
        Vector3d sum = Vector3d::Zero();
        for (Eigen::Index i = 0; i < w.size(); ++i) sum += w[i] * displacement.segment<3>(3 * i);
        return sum;
    }

    const ElasticBody& body;
    int patch = -1;
    Vector3d alpha, god_m, finger_m, u_m;
    PatchNodes node{};
    std::vector<NodalForce> published;
};

// u is a difference of positions in float of 15 times its size; the force solves with a block of L in float.
constexpr Bound kMet{.count = 16, .epsilon = kFloat, .condition = 15.0 + 10.0};

// From a CSV (contact) and from LCM (forces on the patch) the same picture; and the body, so loaded, meets the finger.
TEST(ContactLoads, OfAMaskAreThoseUnderIt) {
    const ElasticBody body(cube_scene(9, 0.3), ForceLaw::kPressureMask, 0.008);
    const Press press(body);
    Tables tables = body.tables();
    for (GodObject god_object : every<GodObject>()) {
        tables.god_object = god_object;
        const ContactLoads loads(tables);
        const std::vector<NodalForce> drawn = loads.spread(
            loads.of(press.node, {press.alpha[0], press.alpha[1], press.alpha[2]}, press.finger_m, press.god_m));
        const std::vector<NodalForce> live = loads.spread(press.published);
        EXPECT_GT(drawn.size(), 6U);
        EXPECT_WITHIN((press.moves(drawn) - press.u_m).norm() / press.u_m.norm(), kMet) << god_object;
        EXPECT_WITHIN((press.moves(live) - press.u_m).norm() / press.u_m.norm(), kMet) << god_object;
        EXPECT_GT((press.moves(press.published) - press.u_m).norm(), 0.1 * press.u_m.norm());  // not spread: a point's
    }
}

TEST(ContactLoads, OfAPointStayOnItsPatch) {
    const ElasticBody body(cube_scene(5, 0.3), ForceLaw::kConsistent);
    const ContactLoads loads(body.tables());
    const Press press(body);
    const std::array<std::int32_t, 3> turned{press.node[2], press.node[0], press.node[1]};
    EXPECT_TRUE(loads.is_patch(turned));
    const auto drawn = loads.of(turned, {press.alpha[2], press.alpha[0], press.alpha[1]}, press.finger_m, press.god_m);
    ASSERT_EQ(drawn.size(), 3U);
    EXPECT_EQ(drawn[1], press.published[0]);  // in the order that was asked for, the servo's bits
    EXPECT_EQ(drawn[2], press.published[1]);
    EXPECT_EQ(loads.spread(drawn), drawn);
    EXPECT_WITHIN((press.moves(drawn) - press.u_m).norm() / press.u_m.norm(), kMet);
    EXPECT_FALSE(loads.is_patch({0, 1, 2}));
}

}  // namespace
}  // namespace haptable::test
