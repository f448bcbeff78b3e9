// SPDX-License-Identifier: GPL-2.0-or-later
// One LCM connection: typed publish and subscribe, waiting with a deadline, errors that say what to do.
//
// UDP is sent by liblcm and received by UdpReceiver; memq:// (this process) and file:// (a log) are liblcm's alone.
#pragma once

#include <lcm/lcm.h>

#include <algorithm>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/link/clock.hpp"
#include "host/link/decode.hpp"
#include "host/link/udp_receiver.hpp"

namespace haptable {

/// LCM's own, so that lcm-logger, lcm-spy and lcm.LCM() hear a session without being told. ttl=0: no packet leaves the
/// machine.
inline constexpr const char* kDefaultUrl = "udpm://239.255.76.67:7667?ttl=0";

/// LCM_DEFAULT_URL where it is set and not empty, else kDefaultUrl.
std::string lcm_url();

/// HAPTABLE_SENDERS: this-machine, where it is not set, or any. Throws Error for another word.
Senders senders();

class Connection {
public:
    /// Throws Error that says what to do when there is no multicast route.
    explicit Connection(const std::string& url = lcm_url());
    ~Connection();
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;

    const std::string& url() const { return url_; }
    /// Messages of a subscribed channel that were not of its type.
    std::uint64_t undecodable() const { return undecodable_; }

    /// Sends one message. Throws Error when LCM does not take it.
    template <typename Message>
    void publish(const char* channel, const Message& message) {
        buffer_.resize(static_cast<std::size_t>(message.getEncodedSize()));  // the capacity stays from tick to tick
        const int size = message.encode(buffer_.data(), 0, static_cast<int>(buffer_.size()));
        send(channel,
             {reinterpret_cast<const std::uint8_t*>(buffer_.data()), static_cast<std::size_t>(std::max(size, 0))});
    }

    /// Sends bytes as they are.
    void send(const char* channel, std::span<const std::uint8_t> bytes);

    /// Calls `handler(message, received)` from handle_until for every message of the channel; `received` is when it
    /// came to this machine, in microseconds since the epoch. What is not whole, or larger than it can be, is counted
    /// and left out. The kernel keeps some hundred messages and drops more of them, so senders number their messages.
    /// The handler may publish, but not wait; an exception that it throws comes out of handle_until.
    template <typename Message>
    void subscribe(const char* channel, std::function<void(const Message&, std::int64_t received_utime)> handler) {
        auto message = std::make_shared<Message>();  // decoded into the same memory each time
        add(channel, [message, handler = std::move(handler)](std::span<const std::uint8_t> bytes, std::int64_t utime) {
            if (!decode_whole(bytes, *message)) return false;
            handler(*message, utime);
            return true;
        });
    }
    /// The same for every message of the channel, undecoded: for who keeps or passes on what others say.
    void listen(const char* channel,
                std::function<void(std::span<const std::uint8_t> bytes, std::int64_t received_utime)> handler);
    /// Calls `work` whenever handle_until has handled all that waited: for who wants the newest message alone.
    void after_all(std::function<void()> work) { after_all_.push_back(std::move(work)); }

    /// For poll: readable when a message waits.
    int fd() const { return receiver_ ? receiver_->fd() : lcm_get_fileno(lcm_); }
    /// Waits for a message until the deadline at most; handles it and those that wait behind it. False: none came, or a
    /// signal did. Throws what a handler threw.
    bool handle_until(Clock::time_point deadline);

private:
    /// False: the bytes are not a message of the channel's type.
    using Raw = std::function<bool(std::span<const std::uint8_t> bytes, std::int64_t received_utime)>;
    struct Subscription {
        Connection* connection;
        std::string channel;
        Raw handler;
    };

    void add(const char* channel, Raw handler);
    bool has_message() const;
    bool wait_until(Clock::time_point deadline) const;
    void handle_one();
    static void on_message(const lcm_recv_buf_t* bytes, const char* channel, void* subscription);
    void call(const Subscription& to, std::span<const std::uint8_t> bytes, std::int64_t received_utime);

    std::string url_;
    lcm_t* lcm_ = nullptr;
    std::optional<UdpReceiver> receiver_;  ///< of udpm:// alone
    std::exception_ptr failed_;            ///< what a handler threw while liblcm's code was its caller
    std::vector<std::function<void()>> after_all_;
    std::vector<std::unique_ptr<Subscription>> subscriptions_;
    std::vector<char> buffer_;
    std::uint64_t undecodable_ = 0;
};

}  // namespace haptable
