// SPDX-License-Identifier: GPL-2.0-or-later
// A serial line: bytes out, bytes in, whatever carries them.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace haptable {

/// Speeds of a serial port: those that termios knows, or whatever its divider makes.
enum class Speeds { standard, any };

class Line {
public:
    /// A tty (raw, 8N1, `baud` bits a second, for us alone) or a Unix socket. Throws Error that names the path.
    static Line open(const std::filesystem::path& path, unsigned baud, Speeds speeds = Speeds::standard);
    /// Two named pipes. They may wait for their partner: opening does not.
    static Line pipes(const std::filesystem::path& to_target, const std::filesystem::path& from_target);
    /// A program of the shell whose standard input and output are the line. It ends with this object.
    static Line program(const std::string& command);

    Line(Line&& other) noexcept;
    Line& operator=(Line&&) = delete;
    ~Line();

    /// What the line is, for messages: "/dev/ttyACM0".
    const std::string& name() const { return name_; }
    /// For poll: readable when there are bytes.
    int fd() const { return in_; }
    /// Takes what is there, without waiting; how much that was. Throws Error when the partner has gone.
    std::size_t read(std::span<std::uint8_t> into);
    /// Sends all of it. Throws Error when the line does not take it within a second.
    void write(std::span<const std::uint8_t> bytes);

private:
    [[noreturn]] void fail_closed() const;
    Line(std::string name, int in, int out, pid_t child = 0);

    std::string name_;
    int in_, out_;
    pid_t child_;
    bool is_port_ = false;  ///< a tty that may be pulled out
};

}  // namespace haptable
