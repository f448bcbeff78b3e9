// SPDX-License-Identifier: GPL-2.0-or-later
// The servo's CSV: one line a tick, what went in and what came out.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "firmware/haptable_body.h"
#include "host/link/text_file.hpp"
#include "host/session/fingers.hpp"
#include "host/session/scene.hpp"

namespace haptable {

/// The servo's CSV under construction: beside its final place until finish(), or, kept, in it.
class ServoRecord {
public:
    /// Throws Error that names the path when it cannot be written there.
    /// fingers: 1 or 2, of each line. has_pose: its last columns are where a body that nothing holds is; before them
    /// stand the modes of a scene that rings.
    ServoRecord(const ServoScene& scene, const std::filesystem::path& path, int fingers = 1, bool has_pose = false);

    /// One line. Floats have 9 digits, so that reading them back gives the same bits. body: with has_pose, where it was
    /// in the tick; contact and god-object are in its coordinates.
    void add(std::int64_t tick, const std::array<float, 3>& finger_m, std::uint32_t buttons, const haptable_output& out,
             const haptable_body_state* body = nullptr, const haptable_modes_state* swings = nullptr);
    /// Of two fingers, where the scene has them: the second's columns follow the first's. One that is not in `in` is
    /// nowhere (nan), and silent.
    void add(std::int64_t tick, const FingerInputs& in, const Fingers& fingers);
    /// The same with outputs that another servo gave: by finger.
    void add(std::int64_t tick, const FingerInputs& in, const std::array<haptable_output, kFingers>& out,
             const haptable_body_state* body = nullptr, const haptable_modes_state* swings = nullptr);
    /// As TextFile::keep and TextFile::flush: for a session, whose record survives whatever happens.
    void keep() { file_.keep(); }
    void flush() { file_.flush(); }
    /// Throws Error when the disk did not take it.
    void finish() { file_.finish(); }

private:
    void end_line(const haptable_body_state* body, const haptable_modes_state* swings);
    void append(const std::array<float, 3>& finger_m, std::uint32_t buttons, const haptable_output& out);
    void append(const std::optional<FingerInput>& input, const haptable_output& out);

    ServoScene scene_;
    TextFile file_;
    std::string line_;
};

}  // namespace haptable
