// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/link/connection.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <cstdlib>
#include <utility>

#include "host/base/error.hpp"

namespace haptable {

namespace {

/// While it lives, standard error goes nowhere: LCM prints its own many lines where we throw one.
class QuietStderr {
public:
    QuietStderr() : kept_(dup(STDERR_FILENO)) {
        const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
        if (kept_ >= 0 && nowhere >= 0) dup2(nowhere, STDERR_FILENO);
        if (nowhere >= 0) close(nowhere);
    }
    ~QuietStderr() {
        if (kept_ < 0) return;
        dup2(kept_, STDERR_FILENO);
        close(kept_);
    }
    QuietStderr(const QuietStderr&) = delete;
    QuietStderr& operator=(const QuietStderr&) = delete;

private:
    int kept_;
};

[[noreturn]] void fail_to_open(const std::string& url) {
    if (url.rfind("udpm://", 0) == 0)
        throw Error("LCM cannot open " + url +
                    ": no multicast route. As root run: ip link set lo up; ip route add 224.0.0.0/4 dev lo; "
                    "or put before the command: sh scripts/loopback.sh");
    if (url.find("pm://") != std::string::npos || url.rfind("tcpq://", 0) == 0)
        throw Error(url +
                    ": haptable speaks udpm://, memq:// and file:// alone, where nobody else's packet can harm it");
    throw Error("LCM cannot open " + url + ": unset LCM_DEFAULT_URL, or set it to something like " + kDefaultUrl);
}

constexpr int kQueued = 1000;      // messages of one subscription over memq://
constexpr int kMostInARow = 1000;  // messages that are handled before the caller looks at its clock again

timespec time_left(Clock::time_point deadline) {
    const Clock::time_point now = Clock::now();
    const auto left = deadline > now ? deadline - now : Clock::duration::zero();
    const auto ns = std::chrono::duration_cast<std::chrono::nanoseconds>(left).count();
    return {ns / 1'000'000'000, ns % 1'000'000'000};
}

}  // namespace

std::string lcm_url() {
    const char* url = std::getenv("LCM_DEFAULT_URL");
    return url != nullptr && *url != '\0' ? url : kDefaultUrl;
}

Senders senders() {
    const char* set = std::getenv("HAPTABLE_SENDERS");
    const std::string word = set != nullptr ? set : "";
    if (word.empty() || word == "this-machine") return Senders::this_machine;
    if (word == "any") return Senders::any;
    throw Error("HAPTABLE_SENDERS is \"" + word +
                "\": give this-machine, or any where other machines may move the motors");
}

Connection::Connection(const std::string& url) : url_(url) {
    const std::optional<MulticastUrl> multicast = parse_multicast_url(url);
    if (!multicast && url.rfind("memq://", 0) != 0 && url.rfind("file://", 0) != 0) fail_to_open(url);
    {
        const QuietStderr quiet;
        lcm_ = lcm_create(url.c_str());
    }
    if (lcm_ == nullptr) fail_to_open(url);
    if (!multicast) return;
    try {
        const Senders heard = senders();
        if (heard == Senders::any)
            fmt::print(stderr, "HAPTABLE_SENDERS=any: whoever is on the network of {} can move the motors\n", url);
        receiver_.emplace(*multicast, heard);
    } catch (...) {
        lcm_destroy(lcm_);
        throw;
    }
}

Connection::~Connection() { lcm_destroy(lcm_); }

void Connection::send(const char* channel, std::span<const std::uint8_t> bytes) {
    if (bytes.empty() || lcm_publish(lcm_, channel, bytes.data(), static_cast<unsigned>(bytes.size())) != 0)
        throw Error(std::string(channel) + ": LCM cannot send on " + url_ + ": is the network interface still up?");
}

void Connection::listen(const char* channel, std::function<void(std::span<const std::uint8_t>, std::int64_t)> handler) {
    add(channel, [handler = std::move(handler)](std::span<const std::uint8_t> bytes, std::int64_t utime) {
        handler(bytes, utime);
        return true;
    });
}

void Connection::add(const char* channel, Raw handler) {
    subscriptions_.push_back(std::make_unique<Subscription>(Subscription{this, channel, std::move(handler)}));
    // liblcm would open a socket of its own here.
    if (receiver_) return receiver_->add_channel(channel);
    lcm_subscription_t* made = lcm_subscribe(lcm_, channel, &Connection::on_message, subscriptions_.back().get());
    if (made == nullptr) fail_to_open(url_);
    lcm_subscription_set_queue_capacity(made, kQueued);
}

void Connection::call(const Subscription& to, std::span<const std::uint8_t> bytes, std::int64_t received_utime) {
    if (!to.handler(bytes, received_utime)) ++undecodable_;
}

// liblcm is C, through which no exception finds its way: it waits until liblcm has returned.
void Connection::on_message(const lcm_recv_buf_t* bytes, const char*, void* subscription) {
    const auto* to = static_cast<Subscription*>(subscription);
    Connection& self = *to->connection;
    if (self.failed_) return;
    // A log's time is that of its record, and liblcm knows no simulated time.
    const bool is_other = self.url_.rfind("file://", 0) == 0 || Clock::simulated() != nullptr;
    const std::int64_t utime = is_other ? utime_now() : bytes->recv_utime;
    try {
        self.call(*to, {static_cast<const std::uint8_t*>(bytes->data), bytes->data_size}, utime);
    } catch (...) {
        self.failed_ = std::current_exception();
    }
}

bool Connection::has_message() const {
    pollfd from{fd(), POLLIN, 0};
    return poll(&from, 1, 0) > 0;
}

bool Connection::wait_until(Clock::time_point deadline) const {
    if (SimulatedTime* simulated = Clock::simulated()) {
        while (!has_message() && simulated->now() < deadline) simulated->leap(deadline);
        return has_message();
    }
    pollfd from{fd(), POLLIN, 0};
    // lcm_handle_timeout knows only milliseconds, and we have a deadline within one.
    const timespec left = time_left(deadline);
    return ppoll(&from, 1, &left, nullptr) > 0;
}

void Connection::handle_one() {
    if (receiver_) {
        const std::optional<UdpReceiver::Packet> packet = receiver_->take();
        if (!packet) return;
        for (const auto& subscription : subscriptions_)
            if (subscription->channel == packet->channel)
                call(*subscription, {packet->data, packet->size}, packet->received_utime);
        return;
    }
    if (lcm_handle(lcm_) != 0) throw Error("LCM " + url_ + " has ended: no more messages can come");
    if (failed_) std::rethrow_exception(std::exchange(failed_, nullptr));
}

bool Connection::handle_until(Clock::time_point deadline) {
    if (!wait_until(deadline)) return false;
    // Who sends faster than we handle does not keep us here.
    int handled = 0;
    do handle_one();
    while (++handled < kMostInARow && wait_until(Clock::time_point::min()));
    for (const auto& work : after_all_) work();
    return true;
}

}  // namespace haptable
