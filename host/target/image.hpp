// SPDX-License-Identifier: GPL-2.0-or-later
// Runs the replay image of a scene on an emulated board: what it computes, bit for bit, and how many instructions.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/body_modes.hpp"
#include "firmware/haptable_scene.h"
#include "firmware/haptable_tool.h"

namespace haptable {

/// The targets that `make firmware` knows.
inline constexpr std::array kTargets{"cortex-m4", "cortex-m7", "cortex-m33", "rv32"};

/// One tick as an image writes it.
struct TargetTick {
    struct Finger {
        std::uint32_t state = 0, patch = 0;
        std::array<float, 3> alpha{}, god_object_m{}, force_n{};
    };
    std::array<Finger, HAPTABLE_HANDS> finger{};  ///< of one finger the first
    std::array<float, 3> position_m{};            ///< after the tick; of a body that nothing holds
    std::array<float, 4> turn{};                  ///< likewise
    std::array<float, HAPTABLE_MODES> q{};        ///< after the tick; of the scene's modes, others 0
    std::uint64_t instructions = 0;               ///< of haptable_step and its call; 0 when not counted

    /// Whether each of so many fingers is in contact.
    bool touches(std::size_t fingers = 1) const;
};

/// Positions of a tick's fingers, one after the other, in metres: [3], or [6] of two.
template <std::size_t size>
using TargetPath = std::vector<std::array<float, size>>;

/// What an image reads that is not linked with a scene: null where the scene has none.
struct TargetScene {
    const haptable_model& model;
    const haptable_pair_model* pair = nullptr;
    const haptable_body* body = nullptr;
    const ServoModes* body_modes = nullptr;
    const haptable_tool_model* tool = nullptr;  ///< with its own pair
};

/// A built image: build/<name>/firmware/<target>.
class TargetImage {
public:
    TargetImage(std::filesystem::path build, const std::string& scene, std::string target);

    /// Why it cannot run here, in one line; empty when it can.
    std::string missing() const;
    /// Steps the scene of the image through the path, a millisecond a tick; a tool as measure does. Throws Error when
    /// the image stops.
    template <std::size_t size>
    std::vector<TargetTick> replay(const TargetPath<size>& path_m) const {
        return count("replay", "", bytes_of(path_m), has_tool_ ? 1 : size / 3, path_m.size(), is_free_);
    }
    /// The same for any scene, by the image that reads it instead of being linked with it (firmware/port/measure.c). Of
    /// a tool [6] are the handle's position and the vector part of its turn; its torque is in q.
    template <std::size_t size>
    std::vector<TargetTick> measure(const TargetScene& scene, const TargetPath<size>& path_m) const {
        return count("measure", bytes_of(scene), bytes_of(path_m), scene.tool != nullptr ? 1 : size / 3, path_m.size(),
                     scene.body != nullptr);
    }
    /// The addresses of the instructions of one tick of the path, in their order.
    template <std::size_t size>
    std::vector<std::uint64_t> trace(const TargetPath<size>& path_m, std::size_t tick) const {
        return trace(bytes_of(path_m).substr(0, (tick + 1) * sizeof path_m[0]), tick);
    }
    /// The displacements, [ticks rows, 3] in metres, that the deform image computes along the path.
    std::vector<std::array<float, 3>> deform(const TargetPath<3>& path_m) const;

private:
    template <std::size_t size>
    static std::string_view bytes_of(const TargetPath<size>& path_m) {
        return {reinterpret_cast<const char*>(path_m.data()), path_m.size() * sizeof path_m[0]};
    }
    static std::string bytes_of(const TargetScene& scene);
    std::vector<std::uint64_t> trace(std::string_view path, std::size_t tick) const;
    struct Written {
        std::string out, counts;
    };
    /// What an image writes for what it reads, and what the plugin counts where it has options.
    Written run(const std::string& image, std::string_view bytes, const std::string& plugin = {}) const;
    std::string counter(const std::string& image) const;
    /// The ticks that an image makes of a scene's bytes and a path, with their counts.
    std::vector<TargetTick> count(const std::string& image, const std::string& scene, std::string_view path,
                                  std::size_t fingers, std::size_t ticks, bool is_free) const;

    std::filesystem::path build_;
    std::string target_;
    std::filesystem::path folder_;
    bool is_free_;   ///< the scene's body
    bool has_tool_;  ///< the scene's hand
};

}  // namespace haptable
