// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/link/log_writer.hpp"

namespace haptable {

namespace {

constexpr std::uint64_t kSyncWord = 0xEDA1DA01;

/// The highest byte first.
void append_number(std::uint64_t number, int bytes, std::string& to) {
    for (int b = bytes - 1; b >= 0; --b) to += static_cast<char>(number >> (8 * b) & 0xFF);
}

}  // namespace

void LogWriter::add(std::string_view channel, std::span<const std::uint8_t> data, std::int64_t utime) {
    event_.clear();
    append_number(kSyncWord, 4, event_);
    append_number(number_++, 8, event_);
    append_number(static_cast<std::uint64_t>(utime), 8, event_);
    append_number(channel.size(), 4, event_);
    append_number(data.size(), 4, event_);
    event_ += channel;
    event_.append(reinterpret_cast<const char*>(data.data()), data.size());
    file_.add(event_);
}

}  // namespace haptable
