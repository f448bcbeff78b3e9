// SPDX-License-Identifier: GPL-2.0-or-later
// A session that a test asks by hand over memq://, for one finger or two: what it publishes, counts and tells.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/session/bridge/line_stepper.hpp"
#include "host/session/local_stepper.hpp"
#include "host/session/servo/replay.hpp"
#include "host/session/session.hpp"
#include "tests/host/session/bridge/fake_target.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/loop/soft_pair.hpp"

namespace haptable::test {

/// Made once.
inline const SoftPair& soft_pair() {
    static const SoftPair pair;
    return pair;
}

/// Two sides of the top, and how deep.
inline Eigen::Vector3d place(std::size_t finger, double depth_m) {
    return {finger == 0 ? 0.0102 : 0.0197, 0.0143, 0.03 - depth_m};
}

/// Its ticks are computed in this process, or behind a line. Real time stands still but where a test lets it go on:
/// what 20 ms of silence do must not hang on how busy this machine is.
class AskedSession {
public:
    static constexpr std::size_t kTwo = 2;

    AskedSession(const ServoScene& of, bool is_behind_a_line, const LineOptions& options = {}) : scene(of) {
        if (is_behind_a_line) behind.emplace(scene);
        if (behind) stepper = std::make_unique<LineStepper>(behind->line, options);
        if (!behind) stepper = std::make_unique<LocalStepper>(scene);
        session.emplace(*stepper, connection, &*record, [this](const std::string& line) { told.push_back(line); });
        time->also([this] { return session->watch_at(); },
                   [this](Clock::time_point now) {
                       session->watch(now);
                       exchange();
                   });
        for (std::size_t finger = 0; finger < kTwo; ++finger) {
            collect(channel_of<servo_force>(finger), forces[finger]);
            collect(channel_of<contact>(finger), contacts[finger]);
        }
        collect(channel_of<servo_status>(), statuses);
        session->take_answers();  // a target's hello
    }
    template <typename Message>
    void collect(const char* channel, std::vector<Message>& into) {
        connection.subscribe<Message>(channel,
                                      [&into](const Message& message, std::int64_t) { into.push_back(message); });
    }

    /// A device's state of a tick of a millisecond.
    static device_state state(std::size_t finger, std::int64_t seq, double depth_m, std::int8_t mode) {
        device_state state = simulated_state(seq, seq * 1000);
        state.session += static_cast<std::int64_t>(finger);
        state.mode = mode;
        std::copy_n(place(finger, depth_m).data(), 3, state.position_m);
        return state;
    }
    static device_state real_state(std::int64_t seq, double depth_m, std::int64_t of_session = kSession) {
        device_state real = state(0, seq, depth_m, device_state::REAL_TIME);
        real.session = of_session;
        return real;
    }
    void exchange() {
        if (behind && answers_by_itself) behind->target.answer();
        session->take_answers();
        handle_all(connection);
    }
    void send(std::size_t finger, const device_state& state) { send(finger, std::vector{state}); }
    /// States that come at once.
    void send(std::size_t finger, const std::vector<device_state>& states) {
        for (const device_state& state : states) connection.publish(channel_of<device_state>(finger), state);
        handle_all(connection);
        exchange();
    }
    void lockstep(std::size_t finger, std::int64_t seq, double depth_m) {
        send(finger, state(finger, seq, depth_m, device_state::SIMULATED));
    }
    void real(std::size_t finger, std::int64_t seq, double depth_m) {
        send(finger, state(finger, seq, depth_m, device_state::REAL_TIME));
    }
    /// A session that always has something due is an error, not a test for ever.
    void wait(std::chrono::milliseconds ms) {
        const Clock::time_point until = time->now() + ms;
        for (int leaps = 0; time->now() < until; ++leaps) {
            if (leaps > 10 + 10 * ms.count()) throw std::runtime_error("the session's work is never done");
            time->leap(until);
        }
        exchange();
    }
    std::int64_t status(const std::string& name) {
        session->publish_status();
        handle_all(connection);
        const servo_status& last = statuses.back();
        const auto found = std::find(last.name.begin(), last.name.end(), name);
        if (found != last.name.end()) return last.value[static_cast<std::size_t>(found - last.name.begin())];
        ADD_FAILURE() << "no counter is called " << name;
        return -1;
    }
    /// The last answer to a finger has no force.
    void expect_no_force(int servo_state, std::size_t finger = 0) const {
        EXPECT_EQ(int{forces[finger].back().servo_state}, servo_state);
        EXPECT_EQ(Eigen::Vector3d(forces[finger].back().force_n), Eigen::Vector3d::Zero());
    }
    /// The host's servo writes the same bytes of the same path.
    void expect_the_hosts_record() {
        record->finish();
        replay(scene, folder / "record.csv", folder / "host.csv", true);
        EXPECT_EQ(read_file(folder / "host.csv"), read_file(folder / "record.csv"));
    }

    const ServoScene scene;
    WorkFolder folder;
    std::optional<SimulatedTime> time{std::in_place};
    Connection connection{"memq://"};
    std::optional<Behind> behind;
    bool answers_by_itself = true;  ///< the target
    std::optional<ServoRecord> record{std::in_place, scene, folder / "record.csv"};
    std::vector<std::string> told;  ///< events, a line each
    std::unique_ptr<Stepper> stepper;
    std::optional<Session> session;
    std::array<std::vector<servo_force>, kTwo> forces;
    std::array<std::vector<contact>, kTwo> contacts;
    std::vector<servo_status> statuses;
};

/// A test's name of where its ticks are computed.
inline constexpr auto name_of_place = [](const testing::TestParamInfo<bool>& of) {
    return of.param ? "Line" : "Process";
};

}  // namespace haptable::test
