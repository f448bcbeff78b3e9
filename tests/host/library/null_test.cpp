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
/// A call does nothing, or gives nothing, and tells its name.
#define HAPTABLE_TOLD(function, ...) \
    function(__VA_ARGS__);           \
    expect_told(#function)
#define HAPTABLE_GIVES(nothing, function, ...)   \
    EXPECT_EQ(function(__VA_ARGS__), (nothing)); \
    expect_told(#function)

TEST(LibraryNull, IsAnErrorEverywhere) {
    haptable_touch touch{}, two[2]{};
    haptable_wrench wrench{};
    float swung[16]{}, x[3]{}, u[1][3]{};
    const float(*at)[3] = &x;
    const float* const each[] = {x, x};
    const float turn[1][4] = {{1.0F, 0.0F, 0.0F, 0.0F}};
    const haptable_object_options options{};
    HAPTABLE_GIVES(nullptr, haptable_object_load, nullptr, 0);
    HAPTABLE_GIVES(nullptr, haptable_object_load_as, nullptr, &options);
    HAPTABLE_GIVES(nullptr, haptable_object_load_as, "build/cube", nullptr);
    EXPECT_EQ(std::string(haptable_object_describe(nullptr).name), "");
    expect_told("haptable_object_describe");
    HAPTABLE_GIVES(-1, haptable_object_deform, nullptr, &touch, nullptr, 0, u);
    HAPTABLE_GIVES(-1, haptable_object_swing, nullptr, swung, nullptr, 0, u);
    HAPTABLE_GIVES(0U, haptable_object_modes, nullptr);
    HAPTABLE_GIVES(0, haptable_object_is_free, nullptr);
    HAPTABLE_GIVES(0U, haptable_object_fingers, nullptr);
    HAPTABLE_GIVES(nullptr, haptable_finger_new, nullptr);
    HAPTABLE_TOLD(haptable_finger_step, nullptr, x, 0, &touch);
    HAPTABLE_GIVES(0, haptable_finger_watch, nullptr, 0, &touch);
    HAPTABLE_TOLD(haptable_finger_buttons, nullptr, 2);
    HAPTABLE_TOLD(haptable_finger_replay, nullptr, at, 1, 0, &touch);
    HAPTABLE_TOLD(haptable_finger_energy, nullptr);
    HAPTABLE_TOLD(haptable_finger_pose, nullptr);
    HAPTABLE_TOLD(haptable_finger_swung, nullptr, swung);
    HAPTABLE_GIVES(0U, haptable_finger_counter, nullptr, 0);
    HAPTABLE_GIVES(nullptr, haptable_fingers_new, nullptr);
    HAPTABLE_TOLD(haptable_fingers_step, nullptr, each, 0, two);
    HAPTABLE_TOLD(haptable_fingers_buttons, nullptr, 0, 2);
    HAPTABLE_TOLD(haptable_fingers_replay, nullptr, at, 1, 0, two);
    HAPTABLE_TOLD(haptable_fingers_energy, nullptr, 0);
    HAPTABLE_TOLD(haptable_fingers_swung, nullptr, swung);
    HAPTABLE_TOLD(haptable_fingers_pose, nullptr);
    HAPTABLE_GIVES(0U, haptable_fingers_counter, nullptr, 0, 0);
    HAPTABLE_GIVES(0U, haptable_object_points, nullptr);
    HAPTABLE_GIVES(nullptr, haptable_held_new, nullptr);
    HAPTABLE_TOLD(haptable_held_step, nullptr, x, turn[0], 0, &wrench);
    HAPTABLE_TOLD(haptable_held_replay, nullptr, at, turn, 1, 0, &wrench);
    HAPTABLE_GIVES(-1, haptable_held_point, nullptr, 0, &touch);
    HAPTABLE_TOLD(haptable_held_buttons, nullptr, 2);
    HAPTABLE_GIVES(0U, haptable_held_counter, nullptr, 0);
    haptable_object_tool(nullptr, nullptr);
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
    HAPTABLE_GIVES(-1, haptable_object_deform, object, nullptr, nullptr, rows, reinterpret_cast<float(*)[3]>(u.data()));
    HAPTABLE_GIVES(-1, haptable_object_deform, object, &touch, nullptr, rows, nullptr);
    HAPTABLE_GIVES(-1, haptable_object_swing, object, nullptr, nullptr, rows, nullptr);
    HAPTABLE_TOLD(haptable_finger_step, finger, nullptr, 0, nullptr);
    HAPTABLE_TOLD(haptable_finger_replay, finger, nullptr, 1, 0, &touch);
    HAPTABLE_GIVES(0, haptable_finger_watch, finger, 100'000, nullptr);
    haptable_finger_free(finger);
    haptable_object_free(object);
}

}  // namespace
}  // namespace haptable::test
