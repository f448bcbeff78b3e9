// SPDX-License-Identifier: GPL-2.0-or-later
// One LCM connection: typed publish and subscribe, waiting with a deadline, errors that say what to do.
#pragma once

#include <lcm/lcm.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/link/clock.hpp"

namespace haptable {

/// Our own multicast group and port, so that other users of LCM on this machine are not disturbed.
/// ttl=0: no packet leaves the machine.
inline constexpr const char* kDefaultUrl = "udpm://239.255.72.84:7684?ttl=0";

/// LCM_DEFAULT_URL where it is set and not empty, else kDefaultUrl.
std::string lcm_url();

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
        send(channel, size);
    }

    /// Calls `handler(message, received)` from handle_until for every message of the channel; `received` is when it
    /// came to this machine, in microseconds since the epoch. Up to `capacity` messages wait for it; LCM drops more
    /// of them silently, so senders number their messages. The handler may publish, but not wait.
    template <typename Message>
    void subscribe(const char* channel, std::function<void(const Message&, std::int64_t received_utime)> handler,
                   int capacity = 1000) {
        auto message = std::make_shared<Message>();  // decoded into the same memory each time
        add(
            channel,
            [message, handler = std::move(handler)](const lcm_recv_buf_t& bytes) {
                if (message->decode(bytes.data, 0, static_cast<int>(bytes.data_size)) < 0) return false;
                handler(*message, bytes.recv_utime);
                return true;
            },
            capacity);
    }

    /// For poll: readable when a message waits.
    int fd() const { return lcm_get_fileno(lcm_); }
    /// Handles one message, waiting for it until the deadline at most. False: none came, or a signal did.
    bool handle_until(Clock::time_point deadline);

private:
    /// False: the bytes are not a message of the channel's type.
    using Raw = std::function<bool(const lcm_recv_buf_t&)>;
    struct Subscription {
        Connection* connection;
        Raw handler;
    };

    void send(const char* channel, int size);
    void add(const char* channel, Raw handler, int capacity);
    static void on_message(const lcm_recv_buf_t* bytes, const char* channel, void* subscription);

    std::string url_;
    lcm_t* lcm_ = nullptr;
    std::vector<std::unique_ptr<Subscription>> subscriptions_;
    std::vector<char> buffer_;
    std::uint64_t undecodable_ = 0;
};

}  // namespace haptable
