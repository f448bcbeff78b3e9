// SPDX-License-Identifier: GPL-2.0-or-later
// The other end of a line: two named pipes or a pty, and a servo that answers frames.
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>

#include "host/link/line.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/loop/line_end.hpp"

namespace haptable::test {

/// What has come there.
inline Bytes take_from(int fd) {
    Bytes bytes(65536);
    pollfd from{fd, POLLIN, 0};
    const ssize_t got = poll(&from, 1, 0) > 0 ? read(fd, bytes.data(), bytes.size()) : 0;
    bytes.resize(got > 0 ? std::size_t(got) : 0);
    return bytes;
}
inline void put_to(int fd, const Bytes& bytes) {
    if (write(fd, bytes.data(), bytes.size()) != ssize_t(bytes.size())) throw std::runtime_error("the line is full");
}

/// Two named pipes, opened so that nobody waits for anybody.
class Pipes {
public:
    Pipes() {
        for (const auto& path : {to_target(), from_target()})
            if (mkfifo(path.c_str(), 0600) != 0) throw std::runtime_error("mkfifo");
        // Read and write: a pipe that has lost its partner for a while is not at its end.
        in_ = open(to_target().c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
        out_ = open(from_target().c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    }
    ~Pipes() { end(); }
    Pipes(const Pipes&) = delete;
    Pipes& operator=(const Pipes&) = delete;

    std::string to_target() const { return (folder_ / "to").string(); }
    std::string from_target() const { return (folder_ / "from").string(); }
    Line line() const { return Line::pipes(to_target(), from_target()); }

    /// What has come to the target's end.
    Bytes take() const { return take_from(in_); }
    /// From the target's end.
    void put(const Bytes& bytes) const { put_to(out_, bytes); }
    /// The same pipes seen from the other end: for a relay.
    Bytes take_answers() const { return take_from(out_); }
    void put_to_target(const Bytes& bytes) const { put_to(in_, bytes); }
    /// No more bytes: who reads comes to the end.
    void end() {
        for (int* fd : {&in_, &out_}) {
            if (*fd >= 0) close(*fd);
            *fd = -1;
        }
    }

private:
    WorkFolder folder_;
    int in_ = -1, out_ = -1;
};

/// A serial port that is none: a terminal of the kernel's, whose other end the target has.
class Pty {
public:
    Pty() : target_(posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
        if (target_ < 0 || grantpt(target_) != 0 || unlockpt(target_) != 0) throw std::runtime_error("no pty");
        name_ = ptsname(target_);
    }
    ~Pty() { vanish(); }
    Pty(const Pty&) = delete;
    Pty& operator=(const Pty&) = delete;

    const std::string& name() const { return name_; }
    int target() const { return target_; }
    Bytes take() const { return take_from(target_); }
    void put(const Bytes& bytes) const { put_to(target_, bytes); }
    /// As if the cable were pulled out.
    void vanish() {
        if (target_ >= 0) close(target_);
        target_ = -1;
    }

private:
    int target_;
    std::string name_;
};

/// A scene behind Pipes or a Pty, as firmware/port/loop.c has it.
template <typename Line>
class FakeTarget : public LineEnd {
public:
    /// Says hello.
    FakeTarget(const ServoScene& scene, const Line& line) : LineEnd(scene), line_(line) { line_.put(begun); }

    /// Takes what has come and answers it; is_lost: not so that anyone hears it. How many states it has answered.
    int answer(bool is_lost = false) {
        int states = 0;
        for (const std::uint8_t byte : line_.take()) {
            Bytes bytes = put(byte);
            const auto frames = LineEar().hear(bytes);
            if (frames.empty()) continue;
            if (take_answer(frames[0].frame, hello, said)) ++states;
            if (is_lost) continue;
            if (damages > 0 && --damages >= 0) bytes[bytes.size() / 2] ^= 1;
            line_.put(bytes);
        }
        return states;
    }

    TargetAnswer said;  ///< last
    int damages = 0;    ///< so many answers are to be damaged on their way
    const haptable_output& output(std::size_t finger = 0) const { return said.output[finger]; }
    const haptable_counters& counters(std::size_t finger = 0) const { return state.servo(finger).counters; }

private:
    const Line& line_;
};

/// A scene at the other end of two pipes.
struct Behind {
    explicit Behind(const ServoScene& scene) : line(pipes.line(), scene), target(scene, pipes) {}
    Pipes pipes;
    SerialTarget line;
    FakeTarget<Pipes> target;
};

}  // namespace haptable::test
