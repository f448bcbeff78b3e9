// SPDX-License-Identifier: GPL-2.0-or-later
// A board at the other end of a pseudo terminal, which answers in a thread of its own.
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace haptable::test {

class PtyBoard {
public:
    using Bytes = std::vector<std::uint8_t>;

    PtyBoard() {
        std::array<char, 128> name{};
        termios raw{};
        cfmakeraw(&raw);
        if (openpty(&ours_, &theirs_, name.data(), &raw, nullptr) != 0) throw std::runtime_error("no pty");
        port_ = name.data();
    }
    virtual ~PtyBoard() {
        close(ours_);
        close(theirs_);
    }
    PtyBoard(const PtyBoard&) = delete;
    PtyBoard& operator=(const PtyBoard&) = delete;

    const std::string& port() const { return port_; }
    /// Says something on its own.
    void say(std::span<const std::uint8_t> bytes) {
        if (::write(ours_, bytes.data(), bytes.size()) < 0) throw std::runtime_error("pty");
    }
    /// Pulls the plug.
    void unplug() {
        end();
        close(std::exchange(ours_, -1));
        close(std::exchange(theirs_, -1));
    }
    /// It hears and does not answer.
    void fall_silent() { is_silent_ = true; }

protected:
    /// Takes what has come so far, removes what it used, and returns what is said.
    virtual Bytes answer(Bytes& held) = 0;
    /// For the constructors and the destructors of boards: what answers is there in between.
    void begin() {
        thread_ = std::thread([this] { run(); });
    }
    void end() {
        ends_ = true;
        if (thread_.joinable()) thread_.join();
    }

    mutable std::mutex mutex_;

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
            const Bytes said = answer(held);
            if (!said.empty() && !is_silent_) say(said);
        }
    }

    std::string port_;
    int ours_ = -1, theirs_ = -1;  // theirs is kept open: a pty that nobody has open gives errors
    std::atomic<bool> ends_ = false, is_silent_ = false;
    std::thread thread_;
};

}  // namespace haptable::test
