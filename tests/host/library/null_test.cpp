// SPDX-License-Identifier: GPL-2.0-or-later
// NULL where the library needs a pointer: nothing is done, and the error says which function was given it.
#include <gtest/gtest.h>

#include <string>

#include "host/library/haptable_library.h"
#include "tests/host/view/cube_tables.hpp"

namespace haptable::test {
namespace {

void expect_told(const char* function) {
    EXPECT_EQ(std::string(haptable_library_error()), std::string(function) + ": a pointer that it needs is NULL");
}

TEST(LibraryNull, IsAnErrorEverywhere) {
    haptable_touch touch{}, two[2]{};
    float swung[16]{}, x[3]{}, u[1][3]{};
    const float(*at)[3] = &x;
    EXPECT_EQ(haptable_object_load(nullptr, 0), nullptr);
    expect_told("haptable_object_load");
    const haptable_object_options options{};
    EXPECT_EQ(haptable_object_load_as(nullptr, &options), nullptr);
    expect_told("haptable_object_load_as");
    EXPECT_EQ(haptable_object_load_as("build/cube", nullptr), nullptr);
    expect_told("haptable_object_load_as");
    EXPECT_EQ(std::string(haptable_object_describe(nullptr).name), "");
    expect_told("haptable_object_describe");
    EXPECT_EQ(haptable_object_deform(nullptr, &touch, nullptr, 0, u), -1);
    expect_told("haptable_object_deform");
    EXPECT_EQ(haptable_object_swing(nullptr, swung, nullptr, 0, u), -1);
    expect_told("haptable_object_swing");
    EXPECT_EQ(haptable_object_modes(nullptr), 0U);
    EXPECT_EQ(haptable_object_is_free(nullptr), 0);
    EXPECT_EQ(haptable_object_fingers(nullptr), 0U);
    EXPECT_EQ(haptable_finger_new(nullptr), nullptr);
    expect_told("haptable_finger_new");
    haptable_finger_step(nullptr, x, 0, &touch);
    expect_told("haptable_finger_step");
    EXPECT_EQ(haptable_finger_watch(nullptr, 0, &touch), 0);
    haptable_finger_buttons(nullptr, 2);
    haptable_finger_replay(nullptr, at, 1, 0, &touch);
    expect_told("haptable_finger_replay");
    EXPECT_EQ(haptable_finger_energy(nullptr).given_j, 0.0);
    EXPECT_EQ(haptable_finger_pose(nullptr).on_floor, 0U);
    haptable_finger_swung(nullptr, swung);
    EXPECT_EQ(haptable_finger_counter(nullptr, 0), 0U);
    EXPECT_EQ(haptable_fingers_new(nullptr), nullptr);
    const float* const each[] = {x, x};
    haptable_fingers_step(nullptr, each, 0, two);
    haptable_fingers_buttons(nullptr, 0, 2);
    haptable_fingers_replay(nullptr, at, 1, 0, two);
    EXPECT_EQ(haptable_fingers_energy(nullptr, 0).given_j, 0.0);
    haptable_fingers_swung(nullptr, swung);
    EXPECT_EQ(haptable_fingers_pose(nullptr).on_floor, 0U);
    EXPECT_EQ(haptable_fingers_counter(nullptr, 0, 0), 0U);
    expect_told("haptable_fingers_counter");
    haptable_wrench wrench{};
    haptable_touch touch_of_point{};
    const float turn[1][4] = {{1.0F, 0.0F, 0.0F, 0.0F}};
    EXPECT_EQ(haptable_object_points(nullptr), 0U);
    haptable_object_tool(nullptr, nullptr);
    EXPECT_EQ(haptable_held_new(nullptr), nullptr);
    haptable_held_step(nullptr, x, turn[0], 0, &wrench);
    haptable_held_replay(nullptr, at, turn, 1, 0, &wrench);
    EXPECT_EQ(haptable_held_point(nullptr, 0, &touch_of_point), -1);
    haptable_held_buttons(nullptr, 2);
    EXPECT_EQ(haptable_held_counter(nullptr, 0), 0U);
    expect_told("haptable_held_counter");
    haptable_held_free(nullptr);
    haptable_object_free(nullptr);
    haptable_finger_free(nullptr);
    haptable_fingers_free(nullptr);
}

TEST(LibraryNull, IsAnErrorForWhatAnObjectNeedsBeside) {
    const TemporaryFolder folder;
    write_cube_tables(folder.path());
    haptable_object* const object = haptable_object_load(folder.path().c_str(), 0);
    ASSERT_NE(object, nullptr) << haptable_library_error();
    haptable_finger* const finger = haptable_finger_new(object);
    ASSERT_NE(finger, nullptr) << haptable_library_error();
    const std::size_t rows = haptable_object_describe(object).row_count;
    haptable_touch touch{};
    std::vector<float> u(3 * rows);
    auto* const all = reinterpret_cast<float(*)[3]>(u.data());
    EXPECT_EQ(haptable_object_deform(object, nullptr, nullptr, rows, all), -1);
    EXPECT_EQ(haptable_object_deform(object, &touch, nullptr, rows, nullptr), -1);
    EXPECT_EQ(haptable_object_swing(object, nullptr, nullptr, rows, nullptr), -1);
    haptable_finger_step(finger, nullptr, 0, nullptr);
    expect_told("haptable_finger_step");
    haptable_finger_replay(finger, nullptr, 1, 0, &touch);
    expect_told("haptable_finger_replay");
    EXPECT_EQ(haptable_finger_watch(finger, 100'000, nullptr), 0);
    haptable_finger_free(finger);
    haptable_object_free(object);
}

}  // namespace
}  // namespace haptable::test
