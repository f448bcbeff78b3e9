// SPDX-License-Identifier: GPL-2.0-or-later
// Runs the replay image of a scene on an emulated board: what it computes, bit for bit, and how many instructions.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/haptable.h"
#include "firmware/haptable_pair.h"

namespace haptable {

/// The targets that `make firmware` knows.
inline constexpr std::array kTargets{"cortex-m4", "cortex-m7", "cortex-m33", "rv32"};

/// One tick as the image prints it.
struct TargetTick {
    std::uint32_t state = 0;
    std::array<std::uint32_t, 3> vertex{};
    std::array<float, 3> alpha{}, god_object_m{}, force_n{};
    std::uint64_t instructions = 0;  ///< of haptable_step and its call; 0 when not counted
};

/// One tick of two fingers, as their image writes it.
struct PairTargetTick {
    struct Finger {
        std::uint32_t state = 0, patch = 0;
        std::array<float, 3> alpha{}, god_object_m{}, force_n{};
    };
    std::array<Finger, 2> finger;
    std::uint64_t instructions = 0;  ///< of haptable_pair_step and its call
};

/// One tick of an image that writes plain numbers.
template <std::size_t size>
struct NumbersTick {
    std::array<float, size> value{};
    std::uint64_t instructions = 0;  ///< of the tick's one function and its call
};

/// A built image: build/<name>/firmware/<target>.
class TargetImage {
public:
    TargetImage(std::filesystem::path build, const std::string& scene, std::string target);

    const std::string& target() const { return target_; }
    std::filesystem::path elf() const { return folder_ / "replay.elf"; }
    /// Why it cannot run here, in one line; empty when it can.
    std::string missing() const;
    /// Steps the servo of the image through the path, a millisecond a position. Throws Error when the image stops.
    std::vector<TargetTick> replay(const std::vector<std::array<float, 3>>& path_m) const;
    /// The same for any model, by the image that reads it instead of being linked with it (firmware/port/measure.c).
    std::vector<TargetTick> measure(const haptable_model& model, const std::vector<std::array<float, 3>>& path_m) const;
    /// The same for two fingers (firmware/port/measure_pair.c); both positions of a tick stand in a row.
    std::vector<PairTargetTick> measure_pair(const haptable_pair_model& pair,
                                             const std::vector<std::array<float, 6>>& path_m) const;
    /// The addresses of the instructions of one tick of the path, in their order.
    std::vector<std::uint64_t> trace(const std::vector<std::array<float, 3>>& path_m, std::size_t tick) const;
    /// The displacements, [ticks rows, 3] in metres, that the deform image computes along the path.
    std::vector<std::array<float, 3>> deform(const std::vector<std::array<float, 3>>& path_m) const;
    /// Force, centre and turn of a body that nothing holds, [ticks], by the image that moves it.
    std::vector<NumbersTick<10>> move_body(const std::vector<std::array<float, 3>>& path_m) const;
    /// Both forces, centre and turn of such a body under two fingers, [ticks].
    std::vector<NumbersTick<13>> move_body_by_two(const std::vector<std::array<float, 6>>& path_m) const;
    /// Force and shift of the surface of a body that rings, [ticks], by the image that steps it.
    std::vector<NumbersTick<6>> ring(const std::vector<std::array<float, 3>>& path_m) const;
    /// Both forces and shifts of such a body under two fingers, [ticks].
    std::vector<NumbersTick<12>> ring_by_two(const std::vector<std::array<float, 6>>& path_m) const;
    /// As move_body_by_two, of one that rings.
    std::vector<NumbersTick<13>> move_ringing_body_by_two(const std::vector<std::array<float, 6>>& path_m) const;
    /// Bytes of the serial line (docs/SPEC.md) through the image that waits behind it; what it sends back.
    std::string loop(std::string_view bytes) const;

private:
    /// What an image writes for what it reads.
    std::string run(const std::string& image, std::string_view bytes) const;
    std::string address_of(const std::string& image, const std::string& symbol) const;
    /// The ticks that an image makes of `bytes`, with their counts.
    std::vector<TargetTick> count(const std::string& image, std::string_view bytes, std::size_t ticks) const;
    /// What an image that writes `size` numbers a tick makes of a path, with their counts.
    template <std::size_t size, std::size_t path_size>
    std::vector<NumbersTick<size>> numbers(const std::string& image,
                                           const std::vector<std::array<float, path_size>>& path_m) const;
    /// Runs it under the plugin; what the plugin wrote, and in `out` what the image did.
    std::string run_counted(const std::string& image, std::string_view bytes, const std::string& more_of_plugin,
                            std::string& out) const;

    std::filesystem::path build_;
    std::string target_;
    std::filesystem::path folder_;
};

}  // namespace haptable
