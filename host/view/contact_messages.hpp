// SPDX-License-Identifier: GPL-2.0-or-later
// HAPTABLE_CONTACT, of two fingers with HAPTABLE_CONTACT_2, from a log or as it comes.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "codegen/loads.hpp"
#include "host/view/frame.hpp"

namespace haptable {

class contact;

/// A message as a frame, its load spread as the scene's mask does; `begin_utime` is the time that counts as 0. Throws
/// Error "SOURCE: ..." when the message is of another model than the tables, or is not one that their servo can have
/// sent.
ContactFrame to_frame(const contact& message, const ContactLoads& loads, std::int64_t begin_utime,
                      const std::string& source);

struct RecordedContacts {
    std::vector<ContactFrame> frames;
    std::int64_t left_out;  ///< messages, and stretches of the log that are none
};

/// The chosen frames of an LCM log, as lcm-logger writes it: at each multiple of every_ms the newest message, by the
/// time of the servo (which is simulated time in lockstep); or the messages whose seq is among `ticks`.
///
/// What is damaged, or of other tables, is left out and counted; where nothing else is there, the first of it is thrown
/// as Error, which for a log of an earlier version says so.
RecordedContacts read_contact_log(const std::filesystem::path& file, const ContactLoads& loads,
                                  const FrameChoice& choice);

/// When a live session ends, besides by Ctrl-C. 0: no limit.
struct LiveLimits {
    std::int64_t frames = 0;
    double seconds = 0.0;
    std::int64_t every_ms = 33;  ///< from frame to frame, at the least
};

struct FollowedContacts {
    std::int64_t messages;  ///< that could be drawn
    std::int64_t left_out;  ///< that could not
};

/// Calls `draw` with the newest message of one servo, so often as `limits` says, until a limit or Ctrl-C. What is
/// damaged, of other tables or of a second servo is left out and counted. Throws Error when none came at all, or no
/// other. `listens` may be empty: it is called with LCM's URL when messages are heard from now on.
FollowedContacts follow_contacts(const ContactLoads& loads, const LiveLimits& limits,
                                 const std::function<void(const ContactFrame&)>& draw,
                                 const std::function<void(const std::string& url)>& listens = {});

}  // namespace haptable
