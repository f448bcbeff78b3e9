// SPDX-License-Identifier: GPL-2.0-or-later
// The check of the tables (docs/SAFETY.md): every table of every part of a scene.
#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <random>

#include "codegen/in_memory.hpp"
#include "codegen/pair.hpp"
#include "tests/bodies.hpp"
#include "tests/loop/every_scene.hpp"

namespace haptable::test {
namespace {

constexpr int kFlips = 2000;  // of each part

/// A body that nothing holds, which rings under two fingers, of the tables given; its check is on.
class Whole {
public:
    explicit Whole(const ServoScene& of) : model(*of.model), pair(*of.pair), body(*of.body), modes(*of.modes) {
        model.check = haptable_check_crc;
        model.crc = haptable_crc_of(&model, haptable_span_of_model);
        pair.model = &model;
        pair.crc = haptable_crc_of(&pair, haptable_span_of_pair);
    }
    Whole(const Whole&) = delete;
    Whole& operator=(const Whole&) = delete;

    /// A state that was not checked before.
    void begin() { haptable_init(&state.scene(), state.memory()); }
    /// What a whole check finds there: the faults of both fingers.
    int faults() {
        begin();
        state.check(HAPTABLE_CHECK_ALL);
        EXPECT_EQ(state.servo(0).check.verdict, state.servo(1).check.verdict);
        EXPECT_EQ(state.servo(0).faults, state.servo(1).faults);
        return state.servo(0).faults;
    }
    int step(float z, std::uint32_t buttons = 0) {
        haptable_input in[2] = {{{0.0131F, 0.0172F, z}, buttons, 1}, {{0.0171F, 0.0132F, z}, buttons, 1}};
        haptable_output out[2];
        state.step(in, now_us += HAPTABLE_TICK_US, out);
        EXPECT_EQ(out[0].state == HAPTABLE_FAULTED, out[1].state == HAPTABLE_FAULTED);
        return out[0].state;
    }

    haptable_model model;
    haptable_pair_model pair;
    haptable_body body;
    haptable_modes modes;
    SceneState state{model, &pair, &body, &modes};
    std::uint32_t now_us = 0;
};

/// Where a bit may be flipped without a table that seems longer than it is: tables and floats, not numbers of rows.
struct Flippable {
    unsigned char* at;
    std::uint32_t bytes;
};

/// counts: whether a field of so many bytes is a number of rows.
std::vector<Flippable> places(const void* tables, haptable_span_fn* span,
                              const std::function<bool(std::uint32_t)>& counts) {
    std::vector<Flippable> found;
    for (std::uint32_t field = 0;; ++field) {
        const haptable_span of = span(tables, field);
        if (of.bytes == HAPTABLE_SPAN_END) return found;
        if (of.bytes > 0 && !counts(of.bytes))
            found.push_back({static_cast<unsigned char*>(const_cast<void*>(of.at)), of.bytes});
    }
}

/// Flips so many bits, one after another, by lot; each is to be found. Returns how many were.
int found(Whole& whole, const std::vector<Flippable>& places, unsigned seed) {
    std::mt19937 random(seed);
    std::size_t all = 0;
    for (const Flippable& place : places) all += place.bytes;
    int found = 0;
    for (int flip = 0; flip < kFlips; ++flip) {
        std::size_t byte = std::uniform_int_distribution<std::size_t>(0, all - 1)(random), in = 0;
        // The first flips are one in each table.
        if (std::size_t(flip) < places.size()) {
            in = std::size_t(flip);
            byte %= places[in].bytes;
        } else {
            while (byte >= places[in].bytes) byte -= places[in++].bytes;
        }
        const auto bit = static_cast<unsigned char>(1U << random() % 8U);
        places[in].at[byte] ^= bit;
        found += whole.faults() == HAPTABLE_FAULT_TABLES ? 1 : 0;
        places[in].at[byte] ^= bit;
    }
    return found;
}

TEST(SceneCheck, NoticesEveryFlippedBitOfEveryPart) {
    Whole whole(every_scene().scene({2, true, true}));
    ASSERT_EQ(whole.faults(), 0);
    // Numbers of rows are those of 16 bits; of the modes one of 8, of the compliance with its degree. The model's are
    // behind its other values.
    const auto of_compliance = [](std::uint32_t bytes) { return bytes <= 3; };
    std::vector<Flippable> of_model = places(&whole.model, haptable_span_of_model, of_compliance);
    of_model[0].bytes = offsetof(haptable_model, packed_count) - offsetof(haptable_model, max_force_n);
    const auto of_16_bits = [](std::uint32_t bytes) { return bytes <= 2; };
    EXPECT_EQ(found(whole, of_model, 1), kFlips);
    EXPECT_EQ(found(whole, places(&whole.pair, haptable_span_of_pair, of_16_bits), 2), kFlips);
    EXPECT_EQ(found(whole, places(&whole.body, haptable_span_of_body, of_16_bits), 3), kFlips);
    EXPECT_EQ(found(whole, places(&whole.modes, haptable_span_of_modes, of_16_bits), 4), kFlips);
    for (std::uint32_t* crc : {&whole.model.crc, &whole.pair.crc, &whole.body.crc, &whole.modes.crc}) {
        *crc ^= 1U;
        EXPECT_EQ(whole.faults(), HAPTABLE_FAULT_TABLES);
        *crc ^= 1U;
    }
    EXPECT_EQ(whole.faults(), 0);
}

// Of clusters, which other tables couple; above are all pairs.
TEST(SceneCheck, CoversEveryTableOfClusters) {
    const ElasticBody body(for_two(cube_scene(5, 0.3), 50'000), ForceLaw::kConsistent);
    const ServoPair coupling = build_pair(body.pair(), body.tables(), body.servo());
    const haptable_model model = body.model();
    const haptable_pair_model pair = pair_in_memory(coupling, body.tables(), model);
    const std::uint32_t whole = haptable_crc_of(&pair, haptable_span_of_pair);
    std::vector<unsigned char*> tables;
#define VALUE(type, name)
#define TABLE(type, name, count) \
    if (pair.name != nullptr) tables.push_back(reinterpret_cast<unsigned char*>(const_cast<type*>(pair.name)));
    HAPTABLE_PAIR_FIELDS(VALUE, TABLE)
#undef VALUE
#undef TABLE
    EXPECT_GE(tables.size(), 7U);
    for (unsigned char* table : tables) {
        *table ^= 4;
        EXPECT_NE(haptable_crc_of(&pair, haptable_span_of_pair), whole);
        *table ^= 4;
    }
}

// 64 bytes at a time, beside the ticks; an acknowledgement does not end what is damaged.
TEST(SceneCheck, GoesOnBesideTheTicksThroughEveryPart) {
    Whole whole(every_scene().scene({2, true, true}));
    ASSERT_EQ(whole.faults(), 0);
    EXPECT_NE(whole.step(0.04F), HAPTABLE_FAULTED);
    for (const bool last : {false, true}) {
        float& value = last ? const_cast<haptable_mode*>(whole.modes.mode)->stiffness : whole.body.mass_kg;
        const float was = value;
        value = std::nextafter(value, 1e9F);
        int slices = 0;
        for (; slices < 100'000 && whole.state.servo(1).faults == 0; ++slices) whole.state.check(HAPTABLE_CHECK_BYTES);
        EXPECT_LT(slices, 100'000);
        EXPECT_EQ(whole.state.servo(0).faults, HAPTABLE_FAULT_TABLES);
        EXPECT_EQ(whole.step(0.04F), HAPTABLE_FAULTED);
        EXPECT_EQ(whole.step(0.04F, HAPTABLE_BUTTON_ACKNOWLEDGE), HAPTABLE_FAULTED) << "they are damaged still";
        value = was;
        for (const int wait : {0, 1}) EXPECT_EQ(whole.step(0.04F), HAPTABLE_FAULTED) << wait << ": it latches";
        EXPECT_EQ(whole.step(0.04F, HAPTABLE_BUTTON_ACKNOWLEDGE), HAPTABLE_FAULTED) << "and was not found whole yet";
        whole.state.check(HAPTABLE_CHECK_ALL);
        EXPECT_EQ(whole.step(0.04F), HAPTABLE_FREE);
    }
}

TEST(SceneCheck, GivesNoForceBeforeItWasMade) {
    Whole whole(every_scene().scene({2, true, true}));
    whole.begin();
    EXPECT_EQ(whole.step(0.04F), HAPTABLE_FAULTED);
    whole.state.check(HAPTABLE_CHECK_ALL);
    EXPECT_EQ(whole.step(0.04F), HAPTABLE_FREE);
}

}  // namespace
}  // namespace haptable::test
