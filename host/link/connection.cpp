// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/link/connection.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

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
    throw Error("LCM cannot open " + url + ": unset LCM_DEFAULT_URL, or set it to something like " + kDefaultUrl);
}

timespec time_left(Clock::time_point deadline) {
    const auto left = std::max(deadline - Clock::now(), Clock::duration::zero());
    const auto ns = std::chrono::duration_cast<std::chrono::nanoseconds>(left).count();
    return {ns / 1'000'000'000, ns % 1'000'000'000};
}

}  // namespace

std::string lcm_url() {
    const char* url = std::getenv("LCM_DEFAULT_URL");
    return url != nullptr && *url != '\0' ? url : kDefaultUrl;
}

Connection::Connection(const std::string& url) : url_(url) {
    const QuietStderr quiet;
    lcm_ = lcm_create(url.c_str());
    if (lcm_ == nullptr) fail_to_open(url);
}

Connection::~Connection() { lcm_destroy(lcm_); }

void Connection::send(const char* channel, int size) {
    if (size < 0 || lcm_publish(lcm_, channel, buffer_.data(), static_cast<unsigned>(size)) != 0)
        throw Error(std::string(channel) + ": LCM cannot send on " + url_ + ": is the network interface still up?");
}

void Connection::add(const char* channel, Raw handler, int capacity) {
    subscriptions_.push_back(std::make_unique<Subscription>(Subscription{this, std::move(handler)}));
    const QuietStderr quiet;
    lcm_subscription_t* made = lcm_subscribe(lcm_, channel, &Connection::on_message, subscriptions_.back().get());
    // LCM sends itself a first message here, and gives up when it does not come back.
    if (made == nullptr) fail_to_open(url_);
    lcm_subscription_set_queue_capacity(made, capacity);
}

void Connection::on_message(const lcm_recv_buf_t* bytes, const char*, void* subscription) {
    const auto* to = static_cast<Subscription*>(subscription);
    if (!to->handler(*bytes)) ++to->connection->undecodable_;
}

bool Connection::handle_until(Clock::time_point deadline) {
    pollfd fd{lcm_get_fileno(lcm_), POLLIN, 0};
    // lcm_handle_timeout knows only milliseconds, and we have a deadline within one.
    const timespec left = time_left(deadline);
    if (ppoll(&fd, 1, &left, nullptr) <= 0) return false;
    if (lcm_handle(lcm_) != 0) throw Error("LCM " + url_ + " has ended: no more messages can come");
    return true;
}

}  // namespace haptable
