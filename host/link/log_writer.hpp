// SPDX-License-Identifier: GPL-2.0-or-later
// An LCM log under construction, as lcm-logger writes it: each flush leaves whole events on the disk, or none.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "host/link/text_file.hpp"

namespace haptable {

class LogWriter {
public:
    /// In its place from the first event on, whatever ends the program. Throws Error that names the path.
    explicit LogWriter(const std::filesystem::path& path) : file_(path) { file_.keep(); }

    /// One message; `utime` is when it came, microseconds since the epoch. Never throws for a full disk.
    void add(std::string_view channel, std::span<const std::uint8_t> data, std::int64_t utime);
    void flush() { file_.flush(); }
    /// True once the disk did not take all.
    bool failed() const { return file_.failed(); }
    long size_bytes() const { return file_.size_bytes(); }
    /// Throws Error when the disk did not take all.
    void finish() { file_.finish(); }

private:
    TextFile file_;
    std::string event_;
    std::uint64_t number_ = 0;
};

}  // namespace haptable
