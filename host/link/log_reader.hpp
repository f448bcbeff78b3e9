// SPDX-License-Identifier: GPL-2.0-or-later
// The events of an LCM log, as lcm-logger writes it. liblcm's own reader believes the lengths that it reads.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>

namespace haptable {

class LogReader {
public:
    /// One message; valid as long as the reader.
    struct Event {
        std::int64_t number;
        std::int64_t utime;  ///< when it was recorded, microseconds since the epoch
        std::string_view channel;
        std::span<const std::uint8_t> data;
    };

    /// Throws Error that names the file where it is not a log.
    explicit LogReader(const std::filesystem::path& file);
    ~LogReader();
    LogReader(const LogReader&) = delete;
    LogReader& operator=(const LogReader&) = delete;

    /// The next whole event. What is damaged is passed over up to the next event's beginning, and counted.
    std::optional<Event> next();
    /// Stretches of the file that were no event; the last one of a log that was cut off is one, too.
    std::int64_t damaged() const { return damaged_; }

private:
    std::optional<Event> event_at(std::size_t at) const;

    std::span<const std::uint8_t> bytes_;
    std::size_t at_ = 0, end_of_last_ = 0;
    std::int64_t damaged_ = 0;
};

}  // namespace haptable
