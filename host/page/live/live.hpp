// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-view --serve: the page of a scene, fed by a real session over LCM; its pointer can be that session's device.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "host/link/live_state.hpp"
#include "host/page/live/ticks.hpp"
#include "host/page/page.hpp"
#include "host/tables/tables.hpp"

namespace haptable {

struct LiveOptions {
    int port = 0;          ///< 0: any that is free
    bool touch = false;    ///< the first page's pointer is a device
    double seconds = 0.0;  ///< 0: until Ctrl-C
    double most_bytes = kPageBytes;
    LiveState::Tell tell;                          ///< gets a line for each event; may be empty
    std::function<void(const std::string&)> show;  ///< gets the page's address, once
};

struct LiveReport {
    std::int64_t pages = 0;    ///< that were sent
    std::int64_t sockets = 0;  ///< of pages that were open
    std::int64_t ticks = 0;    ///< that were heard
    std::int64_t lost_ticks = 0;
    LiveLeftOut left_out;
    std::int64_t pointer_sessions = 0, pointer_ticks = 0;  ///< of the pointer as a device
};

/// Serves until Ctrl-C, or for so long. Only looks, unless `touch`: then the first page has the pointer, as long as it
/// is open; further ones look. Throws Error where no page can be made or served.
LiveReport serve_session(const TablesFolder& folder, const LiveOptions& options);

}  // namespace haptable
