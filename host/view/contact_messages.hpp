// SPDX-License-Identifier: GPL-2.0-or-later
// HAPTABLE_CONTACT, from a log or as it comes.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "host/view/frame.hpp"
#include "host/view/loads.hpp"

namespace haptable {

class contact;

/// A message as a frame, its load spread as the scene's mask does; `begin_utime` is the time that counts as 0. Throws
/// Error "SOURCE: ..." when the message is of another model than the tables, or is not one that their servo can have
/// sent.
ContactFrame to_frame(const contact& message, const ContactLoads& loads, std::int64_t begin_utime,
                      const std::string& source);

/// The chosen frames of an LCM log, as lcm-logger writes it: at each multiple of every_ms the newest message, by the
/// time of the servo (which is simulated time in lockstep); or the messages whose seq is among `ticks`.
std::vector<ContactFrame> read_contact_log(const std::filesystem::path& file, const ContactLoads& loads,
                                           const FrameChoice& choice);

/// When a live session ends, besides by Ctrl-C. 0: no limit.
struct LiveLimits {
    std::int64_t frames = 0;
    double seconds = 0.0;
};

/// Calls `draw` with the newest message, at most 30 times a second, until a limit or Ctrl-C. Returns the number of
/// messages that came. Throws Error when none came at all.
std::int64_t follow_contacts(const ContactLoads& loads, const LiveLimits& limits,
                             const std::function<void(const ContactFrame&)>& draw);

}  // namespace haptable
