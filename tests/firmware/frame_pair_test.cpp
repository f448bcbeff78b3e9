// SPDX-License-Identifier: GPL-2.0-or-later
// Two fingers on a serial line: frames that are the first's but for their type, and the servo's end that gathers ticks.
#include "firmware/haptable_frame_pair.h"

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "tests/loop/soft_pair.hpp"

namespace haptable::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

const haptable_pair_model* tables() {
    static const SoftPair pair;
    static const ServoScene scene = pair.scene();
    return scene.pair;
}

Bytes state_of(int finger, int of_both, std::uint32_t sequence, const haptable_frame_state& state) {
    Bytes bytes(HAPTABLE_FRAME_BYTES);
    bytes.resize(haptable_frame_write_state_of(finger, of_both, sequence, &state, bytes.data()));
    return bytes;
}

// ---- frames --------------------------------------------------------------------------------------------------------

// Byte for byte as documented, with the CRCs that zlib's crc32 gives for these bytes.
TEST(FramePair, WritesTheDocumentedBytes) {
    const haptable_frame_state state{0x01020304, {1.0F, 0.0F, -2.0F}, HAPTABLE_BUTTON_GRAB};
    Bytes want{0xA5, 0x5A, 20, 1, 7, 0, 0, 0,    4, 3, 2, 1, 0,    0,    0x80, 0x3F,
               0,    0,    0,  0, 0, 0, 0, 0xC0, 2, 0, 0, 0, 0x75, 0xEE, 0x16, 0x34};
    EXPECT_EQ(state_of(0, 0, 7, state), want) << "one finger's line stays as it is";
    const auto with = [&want](std::uint8_t type, const Bytes& crc) {
        want[3] = type;
        std::copy(crc.begin(), crc.end(), want.end() - 4);
        return want;
    };
    EXPECT_EQ(state_of(1, 0, 7, state), with(3, {0x28, 0xC8, 0x70, 0xA4}));
    EXPECT_EQ(state_of(0, 1, 7, state), with(5, {0x8E, 0xA4, 0xAB, 0xCF}));
    EXPECT_EQ(state_of(1, 1, 7, state), with(6, {0xDD, 0x12, 0x46, 0xFA}));
    Bytes ask(HAPTABLE_FRAME_BYTES);
    ask.resize(haptable_frame_write_ask(11, ask.data()));
    EXPECT_EQ(ask, (Bytes{0xA5, 0x5A, 0, 7, 11, 0, 0, 0, 0xB2, 0xFA, 0xE3, 0xD4}));
}

TEST(FramePair, TellsFingersByTypeAndTakesNoOther) {
    const Bytes payload(HAPTABLE_FRAME_FORCE_PAYLOAD);
    int states = 0, forces = 0;
    for (int type = 0; type < 256; ++type)
        for (const std::uint8_t length : Bytes{0, 19, HAPTABLE_FRAME_STATE_PAYLOAD, HAPTABLE_FRAME_FORCE_PAYLOAD}) {
            const haptable_frame whole{static_cast<std::uint8_t>(type), length, 1, payload.data()};
            haptable_frame_state state{};
            haptable_output out{};
            std::uint64_t hash = 0;
            int finger = -1, of_both = -1;
            if (haptable_frame_take_state_of(&whole, &finger, &of_both, &state) != 0) {
                ++states;
                EXPECT_EQ(finger, type == 3 || type == 6 ? 1 : 0);
                EXPECT_EQ(of_both, type == 5 || type == 6 ? 1 : 0);
            }
            if (haptable_frame_take_force_of(&whole, &finger, &hash, &out) != 0) {
                ++forces;
                EXPECT_EQ(finger, type == 4 ? 1 : 0);
            }
        }
    EXPECT_EQ(states, 4);
    EXPECT_EQ(forces, 2);
}

// ---- the servo's end -----------------------------------------------------------------------------------------------

/// A force as it came over the line.
struct Felt {
    int finger = -1;
    std::uint32_t sequence = 0;
    haptable_output out{};
};

class FramePairLine : public testing::Test {
protected:
    FramePairLine() {
        haptable_frame_pair_init(tables(), &line);
        haptable_pair_init(tables(), &pair);
        haptable_pair_check(tables(), &pair, HAPTABLE_CHECK_ALL);
    }

    /// Two sides of the top, deeper with every tick.
    static haptable_frame_state state(int finger, std::uint32_t tick) {
        return {tick * 1000, {finger == 0 ? 0.0102F : 0.0197F, 0.0143F, 0.0305F - 1e-4F * static_cast<float>(tick)}, 0};
    }
    static Bytes both(int finger, std::uint32_t tick) { return state_of(finger, 1, tick + 1, state(finger, tick)); }
    static Bytes alone(int finger, std::uint32_t tick) { return state_of(finger, 0, tick + 1, state(finger, tick)); }

    Bytes take(const Bytes& bytes) {
        Bytes all;
        for (const std::uint8_t byte : bytes) {
            Bytes answer(HAPTABLE_FRAME_PAIR_BYTES);
            answer.resize(haptable_frame_pair_take(tables(), &line, byte, answer.data()));
            all.insert(all.end(), answer.begin(), answer.end());
        }
        return all;
    }
    std::vector<Felt> feel(const Bytes& bytes) {
        std::vector<Felt> felt;
        haptable_frame_reader reader;
        haptable_frame_reader_init(&reader);
        for (const std::uint8_t byte : take(bytes)) {
            haptable_frame whole{};
            if (haptable_frame_read(&reader, byte, &whole) == 0) continue;
            Felt one;
            std::uint64_t hash = 0;
            one.sequence = whole.sequence;
            EXPECT_EQ(haptable_frame_take_force_of(&whole, &one.finger, &hash, &one.out), 1);
            EXPECT_EQ(hash, tables()->model->hash);
            felt.push_back(one);
        }
        return felt;
    }
    /// Both, a tick after the other, until this one.
    void press_both(std::uint32_t until) {
        for (std::uint32_t tick = 0; tick < until; ++tick) {
            take(both(0, tick));
            take(both(1, tick));
        }
    }
    std::uint32_t ticks(std::size_t finger) const { return line.pair.servo[finger].counters.ticks; }

    haptable_frame_pair line;
    haptable_pair pair;
};

TEST_F(FramePairLine, ATickOfBothHasThePairsForcesInWhicheverOrderItsStatesCome) {
    for (std::uint32_t tick = 0; tick < 30; ++tick) {
        const int first = static_cast<int>(tick % 2);
        EXPECT_TRUE(take(both(first, tick)).empty()) << "the other is missing";
        const std::vector<Felt> felt = feel(both(1 - first, tick));
        const haptable_frame_state at[2] = {state(0, tick), state(1, tick)};
        haptable_output out[2];
        haptable_pair_step(tables(), &pair, at[0].position_m, at[1].position_m, tick * 1000, out);
        ASSERT_EQ(felt.size(), 2U);
        for (std::size_t finger = 0; finger < 2; ++finger) {
            EXPECT_EQ(felt[finger].finger, static_cast<int>(finger));
            EXPECT_EQ(felt[finger].sequence, tick + 1);
            EXPECT_EQ(felt[finger].out.state, out[finger].state);
            EXPECT_EQ(std::memcmp(felt[finger].out.force_n, out[finger].force_n, sizeof out[finger].force_n), 0);
        }
        if (tick == 29) {
            EXPECT_EQ(out[1].state, HAPTABLE_CONTACT);
        }
    }
}

// What firmware/port/loop.c answers, the second finger's but for its type.
TEST_F(FramePairLine, OneFingerAloneIsAnsweredAsOnALineOfOne) {
    for (const int finger : {0, 1}) {
        haptable_servo servo;
        haptable_init(&servo);
        haptable_check(tables()->model, &servo, HAPTABLE_CHECK_ALL);
        haptable_output out;
        for (std::uint32_t tick = 0; tick < 20; ++tick) {
            const haptable_frame_state at = state(finger, tick);
            haptable_step(tables()->model, &servo, at.position_m, at.time_us, &out);
            Bytes want(HAPTABLE_FRAME_BYTES);
            haptable_frame_write_force(tick + 1, tables()->model->hash, &out, want.data());
            if (finger == 1) haptable_frame_write_force_of(1, tick + 1, tables()->model->hash, &out, want.data());
            ASSERT_EQ(take(alone(finger, tick)), want) << tick;
        }
        EXPECT_EQ(out.state, HAPTABLE_CONTACT);
        haptable_frame_pair_init(tables(), &line);
    }
}

TEST_F(FramePairLine, ATickThatComesTwiceIsAnsweredTwiceAndSteppedOnce) {
    press_both(20);
    const Bytes answer = [&] {
        take(both(0, 20));
        return take(both(1, 20));
    }();
    EXPECT_EQ(answer.size(), 2U * HAPTABLE_FRAME_BYTES);
    EXPECT_TRUE(take(both(1, 20)).empty()) << "a half is no tick";
    EXPECT_EQ(take(both(0, 20)), answer);
    EXPECT_EQ(ticks(0), 21U);
    EXPECT_EQ(ticks(1), 21U);
}

TEST_F(FramePairLine, HalvesOfTwoTicksAreNone) {
    press_both(20);
    take(both(0, 20));
    EXPECT_TRUE(take(both(1, 21)).empty());
    EXPECT_TRUE(take(both(0, 20)).empty()) << "of an earlier tick again";
    EXPECT_TRUE(take(both(0, 22)).empty());
    EXPECT_TRUE(take(both(0, 22)).empty()) << "twice the same finger";
    EXPECT_EQ(ticks(0), 20U);
    EXPECT_EQ(feel(both(1, 22)).size(), 2U);
    EXPECT_EQ(ticks(0), 21U);
}

// A bit makes 3 and 5 the type 1, a state of the first finger alone: without its CRC a type has no meaning.
TEST_F(FramePairLine, ADamagedTypeIsNoFrame) {
    press_both(10);
    for (const Bytes& whole : {both(0, 10), both(1, 10), alone(0, 10), alone(1, 10)})
        for (int bit = 0; bit < 8; ++bit) {
            Bytes damaged = whole;
            damaged[3] ^= static_cast<std::uint8_t>(1U << bit);
            EXPECT_TRUE(take(damaged).empty()) << int{whole[3]} << " as " << int{damaged[3]};
        }
    EXPECT_EQ(ticks(0), 10U);
    EXPECT_EQ(ticks(1), 10U);
    take(both(0, 10));
    EXPECT_EQ(feel(both(1, 10)).size(), 2U) << "the line is whole again";
}

TEST_F(FramePairLine, WhoIsNotInATickIsReleased) {
    press_both(20);
    ASSERT_EQ(line.out[1].state, HAPTABLE_CONTACT);
    take(alone(0, 20));
    EXPECT_EQ(line.out[0].state, HAPTABLE_CONTACT);
    EXPECT_EQ(line.out[1].state, HAPTABLE_SILENT);
    EXPECT_EQ(line.pair.servo[1].counters.silences, 1U);
}

TEST_F(FramePairLine, WhoBeginsInheritsNoContactAndTheOtherKeepsIts) {
    press_both(20);
    ASSERT_EQ(line.out[1].state, HAPTABLE_CONTACT);
    haptable_frame_state anew = state(1, 20);
    anew.buttons = HAPTABLE_FRAME_BEGINS | HAPTABLE_BUTTON_ACKNOWLEDGE;
    take(both(0, 20));
    take(state_of(1, 1, 21, anew));
    EXPECT_EQ(line.out[0].state, HAPTABLE_CONTACT);
    EXPECT_EQ(line.out[1].state, HAPTABLE_FREE) << "inside, where nobody saw it come";
    EXPECT_EQ(line.pair.servo[1].buttons, std::uint32_t{HAPTABLE_BUTTON_ACKNOWLEDGE});
}

TEST_F(FramePairLine, AQuestionIsAnsweredWithTheSecondsForceAndStepsNothing) {
    press_both(20);
    Bytes ask(HAPTABLE_FRAME_BYTES);
    ask.resize(haptable_frame_write_ask(77, ask.data()));
    const std::vector<Felt> felt = feel(ask);
    ASSERT_EQ(felt.size(), 1U);
    EXPECT_EQ(felt[0].finger, 1);
    EXPECT_EQ(felt[0].sequence, 77U);
    EXPECT_EQ(felt[0].out.state, HAPTABLE_CONTACT);
    EXPECT_EQ(ticks(1), 20U);
}

}  // namespace
}  // namespace haptable::test
