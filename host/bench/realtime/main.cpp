// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-bench-realtime: what lab/realtime.py measures a session with: a servo that does nothing, and an ear that
// writes when states and answers were on the wire.
#include <fmt/format.h>

#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/program.hpp"
#include "host/link/connection.hpp"
#include "host/link/messages.hpp"
#include "host/link/realtime.hpp"

namespace haptable {

namespace {

void handle(Connection& connection) {
    while (!interrupted()) connection.handle_until(Clock::now() + std::chrono::milliseconds(100));
}

/// A servo that answers every state at once, and with nothing.
void echo() {
    ask_for_real_time(50);  // as the servo
    Connection connection;
    servo_force answer{};
    answer.servo = random_session();
    answer.servo_state = servo_force::FREE;
    connection.subscribe<device_state>(channel_of<device_state>(), [&](const device_state& state, std::int64_t) {
        answer.utime = utime_now();
        answer.seq = state.seq;
        answer.session = answer.owner = state.session;
        answer.model_hash = state.model_hash;
        connection.publish(channel_of<servo_force>(), answer);
    });
    handle(connection);
}

void note(std::int64_t seq, std::int64_t utime, std::vector<std::int64_t>& times) {
    const auto place = static_cast<std::size_t>(seq);
    if (seq < 0 || place > 100'000'000) return;
    if (place >= times.size()) times.resize(place + 1);
    if (times[place] == 0) times[place] = utime;
}

/// Writes, by sequence number, when a state and its answer were on the wire, us by the kernel's clock, whenever this
/// program came to read them; 0 where it heard none.
void listen() {
    Connection connection;
    std::vector<std::int64_t> sent, answered;
    connection.subscribe<device_state>(channel_of<device_state>(), [&](const device_state& state, std::int64_t utime) {
        note(state.seq, utime, sent);
    });
    connection.subscribe<servo_force>(channel_of<servo_force>(), [&](const servo_force& force, std::int64_t utime) {
        if (force.owner == force.session) note(force.seq, utime, answered);
    });
    handle(connection);
    answered.resize(sent.size());
    fmt::print("sent_us,answered_us\n");
    for (std::size_t i = 0; i < sent.size(); ++i) fmt::print("{},{}\n", sent[i], answered[i]);
}

}  // namespace

}  // namespace haptable

int main(int argc, char** argv) {
    haptable::CommandLine app("Listens to a session until Ctrl-C, or is its servo and does nothing.",
                              "haptable-bench-realtime");
    bool is_echo = false;
    app.flag("--echo", is_echo, "be the servo that does nothing");
    return haptable::run_program(app, argc, argv, [&] {
        haptable::catch_interrupts();
        is_echo ? haptable::echo() : haptable::listen();
    });
}
