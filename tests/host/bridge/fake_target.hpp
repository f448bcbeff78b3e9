// SPDX-License-Identifier: GPL-2.0-or-later
// The other end of a line: two named pipes, and a servo that answers frames as firmware/port/loop.c does.
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <functional>
#include <vector>

#include "firmware/haptable_frame_pair.h"
#include "host/link/line.hpp"
#include "tests/loop/helpers.hpp"

namespace haptable::test {

using Bytes = std::vector<std::uint8_t>;

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
    void put(const Bytes& bytes) const {
        if (write(out_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()))
            throw std::runtime_error("the pipe is full");
    }
    /// The same pipes seen from the other end: for a relay.
    Bytes take_answers() const { return take_from(out_); }
    void put_to_target(const Bytes& bytes) const {
        if (write(in_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()))
            throw std::runtime_error("the pipe is full");
    }
    /// No more bytes: who reads comes to the end.
    void end() {
        for (int* fd : {&in_, &out_}) {
            if (*fd >= 0) close(*fd);
            *fd = -1;
        }
    }

private:
    static Bytes take_from(int fd) {
        Bytes bytes(65536);
        const ssize_t got = read(fd, bytes.data(), bytes.size());
        bytes.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
        return bytes;
    }

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
    Bytes take() const {
        Bytes bytes(4096);
        pollfd from{target_, POLLIN, 0};
        const ssize_t got = poll(&from, 1, 0) > 0 ? read(target_, bytes.data(), bytes.size()) : 0;
        bytes.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
        return bytes;
    }
    void put(const Bytes& bytes) const {
        if (write(target_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()))
            throw std::runtime_error("the pty is full");
    }
    /// As if the cable were pulled out.
    void vanish() {
        if (target_ >= 0) close(target_);
        target_ = -1;
    }

private:
    int target_;
    std::string name_;
};

/// Answers states, behind Pipes or a Pty; a repeated one as before.
template <typename Line>
class FakeTarget {
public:
    FakeTarget(const haptable_model* model, const Line& line) : model_(model), line_(line) {
        haptable_init(&servo_);
        haptable_check(model_, &servo_, HAPTABLE_CHECK_ALL);
        haptable_frame_reader_init(&reader_);
    }

    /// How many states it has found among the bytes that have come.
    int answer() {
        int states = 0;
        for (const std::uint8_t byte : line_.take()) {
            haptable_frame whole{};
            haptable_frame_state state{};
            if (haptable_frame_read(&reader_, byte, &whole) == 0 || haptable_frame_take_state(&whole, &state) == 0)
                continue;
            ++states;
            if (whole.sequence != last_ || states_ == 0) {
                haptable_watch(&servo_, state.time_us, &output_);
                haptable_buttons(&servo_, state.buttons);
                haptable_step(model_, &servo_, state.position_m, state.time_us, &output_);
            }
            ++states_;
            last_ = whole.sequence;
            Bytes bytes(HAPTABLE_FRAME_BYTES);
            bytes.resize(haptable_frame_write_force(whole.sequence, hash, &output_, bytes.data()));
            line_.put(bytes);
        }
        return states;
    }

    std::uint64_t hash = SoftBox::kHash;
    const haptable_counters& counters() const { return servo_.counters; }
    haptable_output& output() { return output_; }

private:
    const haptable_model* model_;
    const Line& line_;
    haptable_servo servo_{};
    haptable_output output_{};
    haptable_frame_reader reader_{};
    std::uint32_t last_ = 0;
    int states_ = 0;
};

/// The same of two fingers, as firmware/port/loop_pair.c does.
template <typename Line>
class FakePairTarget {
public:
    FakePairTarget(const haptable_pair_model* tables, const Line& line) : tables_(tables), line_(line) {
        haptable_frame_pair_init(tables_, &end_);
    }

    /// Takes what has come, and answers it but for frames of the type that is lost. How many forces it has sent.
    int answer(std::uint8_t lost_type = 0) {
        int forces = 0;
        for (const std::uint8_t byte : line_.take()) {
            Bytes answer(HAPTABLE_FRAME_PAIR_BYTES);
            answer.resize(haptable_frame_pair_take(tables_, &end_, byte, answer.data()));
            for (std::size_t at = 0; at < answer.size(); at += HAPTABLE_FRAME_BYTES) {
                if (answer[at + 3] == lost_type) continue;
                line_.put(Bytes(answer.begin() + static_cast<std::ptrdiff_t>(at),
                                answer.begin() + static_cast<std::ptrdiff_t>(at + HAPTABLE_FRAME_BYTES)));
                ++forces;
            }
        }
        return forces;
    }

    const haptable_frame_pair& end() const { return end_; }
    const haptable_counters& counters(std::size_t finger) const { return end_.pair.servo[finger].counters; }

private:
    const haptable_pair_model* tables_;
    const Line& line_;
    haptable_frame_pair end_{};
};

}  // namespace haptable::test
