// SPDX-License-Identifier: MIT
// The deepest point of a body that a finger presses: c++ -std=c++17 touch.cpp $(pkg-config --cflags --libs haptable)
#include <haptable_library.h>

#include <algorithm>
#include <array>
#include <iostream>
#include <memory>
#include <vector>

int main(int argc, char** argv) {
    const std::unique_ptr<haptable_object, decltype(&haptable_object_free)> object(
        haptable_object_load(argc > 1 ? argv[1] : "build/cube", 0), haptable_object_free);
    const std::unique_ptr<haptable_finger, decltype(&haptable_finger_free)> finger(
        object ? haptable_finger_new(object.get()) : nullptr, haptable_finger_free);
    haptable_touch touch{};
    for (std::uint32_t tick = 0; finger && tick < 60; ++tick) {
        const std::array<float, 3> position_m{0.015F, 0.015F, 0.032F - 1e-4F * static_cast<float>(tick)};
        haptable_finger_step(finger.get(), position_m.data(), 1000 * tick, &touch);
    }
    std::vector<std::array<float, 3>> u(object ? haptable_object_describe(object.get()).row_count : 0);
    if (!finger ||
        haptable_object_deform(object.get(), &touch, nullptr, u.size(), reinterpret_cast<float(*)[3]>(u.data())) != 0) {
        std::cerr << "touch: " << haptable_library_error() << '\n';
        return 1;
    }
    const auto deepest = std::min_element(u.begin(), u.end(), [](auto& a, auto& b) { return a[2] < b[2]; });
    const auto node = haptable_object_describe(object.get()).row_node[deepest - u.begin()];
    std::cout << "node " << node << " goes down by " << -1e3F * (*deepest)[2] << " mm\n";
}
