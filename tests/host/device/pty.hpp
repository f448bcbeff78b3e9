// SPDX-License-Identifier: GPL-2.0-or-later
// A board at the other end of a pseudo terminal: bytes come to a function in a thread of its own, which answers.
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace haptable::test {

class PtyBoard {
public:
    using Bytes = std::vector<std::uint8_t>;

    /// `answer`: takes what has come so far, removes what it used, and returns what is said.
    explicit PtyBoard(std::function<Bytes(Bytes&)> answer) : answer_(std::move(answer)) {
        std::array<char, 128> name{};
        termios raw{};
        cfmakeraw(&raw);
        if (openpty(&ours_, &theirs_, name.data(), &raw, nullptr) != 0) throw std::runtime_error("no pty");
        name_ = name.data();
        thread_ = std::thread([this] { run(); });
    }
    ~PtyBoard() { unplug(); }
    PtyBoard(const PtyBoard&) = delete;
    PtyBoard& operator=(const PtyBoard&) = delete;

    const std::string& name() const { return name_; }
    /// Says something on its own.
    void say(std::span<const std::uint8_t> bytes) {
        if (::write(ours_, bytes.data(), bytes.size()) < 0) throw std::runtime_error("pty");
    }
    /// Pulls the plug.
    void unplug() {
        if (!thread_.joinable()) return;
        ends_ = true;
        thread_.join();
        close(ours_);
        close(theirs_);
    }

private:
    void run() {
        Bytes held;
        while (!ends_) {
            pollfd fd{ours_, POLLIN, 0};
            if (poll(&fd, 1, 5) <= 0) continue;
            std::array<std::uint8_t, 1024> bytes;
            const ssize_t got = ::read(ours_, bytes.data(), bytes.size());
            if (got <= 0) continue;
            held.insert(held.end(), bytes.begin(), bytes.begin() + got);
            const Bytes said = answer_(held);
            if (!said.empty()) say(said);
        }
    }

    std::function<Bytes(Bytes&)> answer_;
    std::string name_;
    int ours_ = -1, theirs_ = -1;  // theirs is kept open: a pty that nobody has open gives errors
    std::atomic<bool> ends_ = false;
    std::thread thread_;
};

}  // namespace haptable::test
