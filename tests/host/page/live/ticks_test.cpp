// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/page/live/ticks.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "codegen/in_memory.hpp"
#include "host/link/clock.hpp"
#include "tests/host/view/cube_tables.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

/// Messages by hand, of a contact on the first patch.
class LiveTicksTest : public testing::Test {
protected:
    servo_force force(std::int64_t seq) const {
        servo_force force{};
        force.seq = seq;
        force.session = force.owner = 5;
        force.servo = 7;
        force.model_hash = hash;
        force.servo_state = servo_force::CONTACT;
        force.force_n[2] = 0.5;
        return force;
    }
    contact load(std::int64_t seq) const {
        contact load{};
        load.seq = seq;
        load.session = 5;
        load.servo = 7;
        load.model_hash = hash;
        load.count = 3;
        for (std::size_t c = 0; c < 3; ++c) {
            load.node.push_back(tables.patch[0][c]);
            load.force_n.push_back({0.0, 0.0, -0.1 * static_cast<double>(c + 1)});
            for (std::size_t a = 0; a < 3; ++a)
                load.god_object_m[a] += alpha[c] * tables.position[static_cast<std::size_t>(tables.patch[0][c])][a];
        }
        return load;
    }
    void take(const servo_force& force, const contact& load) {
        ticks.take(force);
        ticks.take(load);
    }
    void take(std::int64_t seq) { take(force(seq), load(seq)); }
    /// Three ticks of a body that moves; of where it is, which `change` makes another in each, the first says nothing.
    template <typename Message, typename Change>
    void take_moving(LiveTicks& moving, Message& where, const Change& change) const {
        where.servo = 7;
        where.model_hash = hash;
        moving.take(force(0));
        moving.take(load(0));
        EXPECT_TRUE(moving.ticks().empty());
        EXPECT_EQ(moving.lost(), 1);
        for (std::int64_t seq = 1; seq < 3; ++seq) {
            where.utime = seq;
            change(static_cast<double>(seq));
            moving.take(force(seq));
            moving.take(where);
            contact its = load(seq);
            its.utime = seq;
            moving.take(its);
        }
        EXPECT_EQ(moving.ticks().size(), 2U);
    }

    TemporaryFolder folder;
    Tables tables = (write_cube_tables(folder.path() / "cube"), read_tables(folder.path() / "cube"));
    ServoModel servo = build_model(tables);
    haptable_model model = model_in_memory(tables, servo);
    std::int64_t hash = static_cast<std::int64_t>(model.hash);
    LiveTicks ticks{tables, servo, model.hash};
    const std::array<double, 3> alpha{0.5, 0.375, 0.125};
};

TEST_F(LiveTicksTest, JoinAForceAndItsContact) {
    device_state state{};
    state.session = 5;
    state.buttons = 2;
    take(0);
    ticks.take(state);
    take(1);
    const std::vector<LiveTick> made = ticks.ticks();
    ASSERT_EQ(made.size(), 2U);
    EXPECT_TRUE(ticks.ticks().empty());
    EXPECT_EQ(made[0].buttons, 0U);
    EXPECT_EQ(made[1].buttons, 2U);
    const LiveTick& tick = made[1];
    EXPECT_EQ(tick.state, 2U);
    EXPECT_EQ(tick.force_n[2], 0.5F);
    const auto& corners = servo.patch[std::size_t(tick.patch)];
    for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_EQ(servo.node[std::size_t(tick.vertex[c])], tables.patch[0][c]);
        EXPECT_EQ(std::count(corners.begin(), corners.end(), tick.vertex[c]), 1);
        EXPECT_EQ(tick.nodal_force_n[c][2], float(-0.1 * double(c + 1)));
        // Sums of a few products of numbers below 1, in double, then in float.
        EXPECT_WITHIN(std::abs(double(tick.alpha[c]) - alpha[c]), .count = 16, .epsilon = kFloat);
    }
}

// A body that relaxes keeps a dent, which is drawn though nothing touches it.
TEST_F(LiveTicksTest, KeepTheDentThatAFingerLeft) {
    servo_force free = force(0);
    free.servo_state = servo_force::FREE;
    take(free, load(0));
    const std::vector<LiveTick> made = ticks.ticks();
    ASSERT_EQ(made.size(), 1U);
    EXPECT_EQ(made[0].state, 1U);
    EXPECT_GE(made[0].vertex[0], 0);
    EXPECT_EQ(made[0].nodal_force_n[2][2], -0.3F);
}

// Messages of one time are one tick, whoever comes first; who has no answer in it is as it was, and nowhere at first.
TEST_F(LiveTicksTest, JoinTheFingersOfATick) {
    SimulatedTime time;
    LiveTicks both(tables, servo, model.hash, 2);
    const auto answer = [&](std::size_t finger, std::int64_t seq, std::int64_t utime) {
        servo_force felt = force(seq);
        contact its = load(seq);
        felt.session = felt.owner = its.session = finger == 0 ? 5 : 6;
        felt.force_n[2] = finger == 0 ? 0.5 : 0.25;
        its.utime = utime;
        both.take(felt, finger);
        both.take(its, finger);
    };
    const auto forces = [&] {
        std::vector<float> list;
        for (const LiveTick& tick : both.ticks()) list.push_back(tick.force_n[2]);
        return list;
    };
    answer(0, 0, 1000);
    EXPECT_TRUE(both.ticks().empty()) << "the other may come yet";
    answer(0, 1, 2000);
    EXPECT_EQ(forces(), (std::vector<float>{0.5F, 0.0F})) << "it did not";
    answer(1, 0, 2000);
    EXPECT_EQ(forces(), (std::vector<float>{0.5F, 0.25F}));
    answer(0, 2, 3000);
    answer(1, 1, 3500);
    EXPECT_EQ(both.ticks().size(), 2U) << "they have two times";
    time.leap(time.now() + std::chrono::milliseconds(4));
    EXPECT_EQ(forces(), (std::vector<float>{0.5F, 0.25F})) << "the first is as it was";
    EXPECT_EQ(both.lost(), 0);
    ticks.take(force(9), 1);
    ticks.take(load(9), 1);
    EXPECT_TRUE(ticks.ticks().empty()) << "a scene of one finger has no second";
}

// The pose comes before the contacts of its tick; a body that nobody has told of is not drawn.
TEST_F(LiveTicksTest, KnowWhereAFreeBodyIs) {
    LiveTicks moving(tables, servo, model.hash, 1, true);
    body_pose pose{};
    pose.turn[0] = 1.0;
    take_moving(moving, pose, [&](double seq) { pose.centre_m[2] = 0.25 * seq; });
    ASSERT_EQ(moving.poses().size(), 2U);
    EXPECT_EQ(moving.poses()[1].centre_m[2], 0.5F);
    pose.turn[1] = std::numeric_limits<double>::infinity();
    moving.take(pose);
    EXPECT_EQ(moving.left_out().damaged, 1);
    pose.model_hash = hash + 1;
    moving.take(pose);
    EXPECT_EQ(moving.left_out().other_tables, 1);
}

// So does how far it has swung; one that nobody has told of is not drawn.
TEST_F(LiveTicksTest, KnowHowFarABodyHasSwung) {
    LiveTicks ringing(tables, servo, model.hash, 1, false, 2);
    body_modes modes{};
    modes.count = 2;
    take_moving(ringing, modes, [&](double seq) { modes.swung[1] = 0.25F * static_cast<float>(seq); });
    EXPECT_EQ(ringing.swings(), (std::vector<float>{0.0F, 0.25F, 0.0F, 0.5F}));
    modes.swung[0] = std::numeric_limits<float>::quiet_NaN();
    ringing.take(modes);
    modes.count = 3;
    ringing.take(modes);
    EXPECT_EQ(ringing.left_out().damaged, 2);
    modes.model_hash = hash + 1;
    ringing.take(modes);
    EXPECT_EQ(ringing.left_out().other_tables, 1);
}

TEST_F(LiveTicksTest, CountWhatIsNone) {
    take(0);
    contact none = load(1);
    none.model_hash = hash + 1;
    take(force(1), none);
    EXPECT_EQ(ticks.left_out().other_tables, 1);
    EXPECT_EQ(ticks.other_hash(), static_cast<std::uint64_t>(hash + 1));

    servo_force second = force(1);
    contact its = load(1);
    second.servo = its.servo = 8;
    take(second, its);
    EXPECT_EQ(ticks.left_out().other_servo, 1);

    std::vector<contact> damaged(6, load(1));
    damaged[0].node[1] = 1 << 20;
    damaged[1].node[1] = -1;
    damaged[2].node[1] = damaged[2].node[0];
    damaged[3].force_n[2][0] = std::numeric_limits<double>::quiet_NaN();
    damaged[4].count = 2;
    damaged[5].count = 0;
    damaged[5].node.clear();
    damaged[5].force_n.clear();
    for (const contact& one : damaged) take(force(1), one);
    servo_force endless = force(1);
    endless.force_n[0] = std::numeric_limits<double>::infinity();
    take(endless, load(1));
    EXPECT_EQ(ticks.left_out().damaged, 7);

    servo_force refusal = force(1);
    refusal.owner = 6;
    ticks.take(refusal);
    EXPECT_EQ(ticks.refusals(), 1);
    EXPECT_EQ(ticks.lost(), 0);
    take(4);  // 1 to 3 were not heard whole
    EXPECT_EQ(ticks.lost(), 3);
    ticks.take(load(5));  // its force was not
    EXPECT_EQ(ticks.lost(), 4);
    EXPECT_EQ(ticks.ticks().size(), 2U);
}

}  // namespace
}  // namespace haptable::test
