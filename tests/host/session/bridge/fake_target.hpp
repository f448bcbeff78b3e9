// SPDX-License-Identifier: GPL-2.0-or-later
// The other end of a line: two named pipes or a pty, and a servo that answers frames as firmware/port/loop.c does.
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstdlib>

#include "host/link/line.hpp"
#include "host/session/scene.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/loop/line_bytes.hpp"

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
class FakeTarget {
public:
    /// Says hello.
    FakeTarget(const ServoScene& scene, const Line& line) : line_(line), state_(state_of(scene)) {
        state_.check(HAPTABLE_CHECK_ALL);
        haptable_line_reader_init(room_.data(), HAPTABLE_LINE_ANSWER_BYTES, &reader_);
        haptable_line_describe(&state_.scene(), &hello);
        std::uint32_t count = 0;
        const std::uint8_t* bytes = haptable_line_begin(&state_.scene(), &end_, &count);
        line_.put(Bytes(bytes, bytes + count));
    }

    /// Takes what has come and answers it. How many states it has answered.
    int answer(bool is_lost = false) {
        int states = 0;
        for (const std::uint8_t byte : line_.take()) {
            std::uint32_t count = 0;
            const std::uint8_t* bytes = haptable_line(&state_.scene(), &state_.servo(0), &end_, byte, &count);
            if (count == 0) continue;
            Bytes said(bytes, bytes + count);
            if (hear(said)) ++states;
            if (is_lost) continue;
            if (damages > 0 && --damages >= 0) said[said.size() / 2] ^= 1;
            line_.put(said);
        }
        return states;
    }

    haptable_line_hello hello{};  ///< what it says of itself
    int damages = 0;              ///< so many answers are to be damaged on their way
    /// The last answer.
    const haptable_line_answer& said() const { return said_; }
    const haptable_output& output(std::size_t finger = 0) const { return said_.out[finger]; }
    const haptable_counters& counters(std::size_t finger = 0) const { return state_.servo(finger).counters; }

private:
    /// Whether it is a tick's.
    bool hear(const Bytes& bytes) {
        haptable_line_frame frame{};
        int whole = 0;
        for (const std::uint8_t byte : bytes) whole += haptable_line_read(&reader_, byte, &frame);
        return whole == 1 && haptable_line_take_answer(&frame, &hello, &said_) != 0;
    }

    const Line& line_;
    SceneState state_;
    haptable_line_end end_{};
    std::array<std::uint8_t, HAPTABLE_LINE_ANSWER_BYTES> room_{};
    haptable_line_reader reader_{};
    haptable_line_answer said_{};
};

}  // namespace haptable::test
