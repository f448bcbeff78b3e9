// SPDX-License-Identifier: GPL-2.0-or-later
// The servo's CSV: one line a tick, what went in and what came out.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "firmware/haptable_body.h"
#include "host/link/text_file.hpp"
#include "host/session/scene.hpp"
#include "host/session/stepper.hpp"

namespace haptable {

/// The servo's CSV under construction: beside its final place until finish(), or, kept, in it.
class ServoRecord {
public:
    /// Columns of each of the scene's fingers, of its modes, and of where a body that nothing holds is. Throws Error
    /// that names the path when it cannot be written there.
    ServoRecord(const ServoScene& scene, const std::filesystem::path& path);

    /// One line. Floats have 9 digits, so that reading them back gives the same bits. A finger that is not in `in` is
    /// nowhere (nan). body: where it was in the tick; contact and god-object are in its coordinates.
    void add(std::int64_t tick, const FingerInputs& in, const FingerOutputs& out,
             const haptable_body_state* body = nullptr, const haptable_modes_state* modes = nullptr,
             const ToolOutput* tool = nullptr);
    /// As TextFile::keep and TextFile::flush: for a session, whose record survives whatever happens.
    void keep() { file_.keep(); }
    void flush() { file_.flush(); }
    /// Throws Error when the disk did not take it.
    void finish() { file_.finish(); }

private:
    void append(const std::optional<FingerInput>& input, const haptable_output& out);
    void append_contact(const haptable_output& out);
    void append_tool(const std::array<float, 4>& turn, const ToolOutput& tool);

    ServoScene scene_;
    TextFile file_;
    std::string line_;
};

}  // namespace haptable
