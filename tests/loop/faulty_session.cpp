// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/loop/faulty_session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/session/local_stepper.hpp"
#include "host/session/serve.hpp"
#include "host/session/session.hpp"

namespace haptable::test {

namespace {

constexpr Clock::duration kSilence = std::chrono::milliseconds(20);

/// The hand presses the button that acknowledges for a tenth of each second.
class Acknowledging : public Path {
public:
    explicit Acknowledging(std::unique_ptr<Path> path) : path_(std::move(path)) {}
    double duration_s() const override { return path_->duration_s(); }
    HandGoal at(double time_s) const override {
        HandGoal goal = path_->at(time_s);
        if (std::fmod(time_s, 1.0) < 0.1) goal.buttons |= HAPTABLE_BUTTON_ACKNOWLEDGE;
        return goal;
    }

private:
    std::unique_ptr<Path> path_;
};

/// From f to the nearest of what is between none and `last`.
double rise_from(const Eigen::Vector3d& last_n, const Eigen::Vector3d& force_n) {
    const double square = last_n.squaredNorm();
    const double share = square > 0.0 ? std::clamp(force_n.dot(last_n) / square, 0.0, 1.0) : 0.0;
    return (force_n - share * last_n).norm();
}

class WatchedSession {
public:
    WatchedSession(const ServoScene& scene, const FaultPlan& plan, std::uint64_t seed, double seconds,
                   const std::function<void(std::int64_t)>& each_tick)
        : model_(*scene.model),
          limit_n_(scene.model->max_force_n),
          connection_("memq://"),
          stepper_(scene),
          servo_(stepper_, connection_, nullptr),
          path_(std::make_unique<Acknowledging>(scripted_path("poke,drag,circle", PathOptions{}))),
          each_tick_(each_tick) {
        time_.also([this] { return std::min(servo_.watch_at(), next_status_); },
                   [this](Clock::time_point now) { work(now); });
        connection_.subscribe<servo_force>(channel_of<servo_force>(),
                                           [this](const servo_force& force, std::int64_t) { see(force); });
        options_.faults = plan;
        options_.seed = seed;
        options_.seconds = seconds;
        options_.patience_s = 0.0;  // whatever goes wrong may go wrong with the first state
        options_.watch = [this](const DeviceRow& row) { see(row); };
    }

    Watched run() {
        const PointDevice device(Device{}, Hand{}, path_->at(0.0).position_m);
        watched_.device = DeviceSession(device, *path_, connection_, options_, nullptr).run();
        watched_.silences = stepper_.report().counters.silences;
        return watched_;
    }

private:
    /// As the servo's own loop does.
    void work(Clock::time_point now) {
        servo_.watch(now);
        if (now < next_status_) return;
        servo_.publish_status();
        next_status_ = now + kStatusPeriod;
    }

    void complain(std::int64_t tick, const std::string& what) {
        if (watched_.violation.empty()) watched_.violation = fmt::format("tick {}: {}", tick, what);
    }

    void see(const servo_force& force) {
        ++watched_.forces;
        servo_force_n_ = std::hypot(force.force_n[0], force.force_n[1], force.force_n[2]);
        // The servo cuts in float32.
        if (!(servo_force_n_ <= limit_n_ * (1.0 + 1e-6)))
            complain(force.seq, fmt::format("the servo gives {} N, the limit is {}", servo_force_n_, limit_n_));
        if (force.servo_state != servo_force::CONTACT && force.servo_state != servo_force::LIMITED &&
            servo_force_n_ > 0.0)
            complain(force.seq, fmt::format("{} N in state {}", servo_force_n_, force.servo_state));
        if (force.session != force.owner) return;  // a damaged name: told that the servo is another's
        const Eigen::Vector3d force_n(force.force_n);
        const double rise_n = rise_from(last_force_n_, force_n);
        if (model_.rate != nullptr && rise_n > model_.rate_n + limit_n_ * 1e-6)
            complain(force.seq, fmt::format("the force rises by {} N, the limit is {}", rise_n, model_.rate_n));
        last_force_n_ = force_n;
        watched_.limited += force.servo_state == servo_force::LIMITED ? 1 : 0;
        watched_.faulted += force.servo_state == servo_force::FAULTED ? 1 : 0;
    }

    void see(const DeviceRow& row) {
        const double force_n = row.force_n.norm();
        if (!(force_n <= limit_n_ * (1.0 + 1e-12)))
            complain(row.tick, fmt::format("the motors give {} N, the limit is {}", force_n, limit_n_));
        if (force_n > 0.0) ++watched_.felt_ticks;
        // At the end of a tick: the state that is answered was published at its begin.
        if (force_n > 0.0 && (row.tick + 1 - row.answered_tick) * kTick > kSilence)
            complain(row.tick, fmt::format("{} N that answer tick {}", force_n, row.answered_tick));
        if (servo_.has_states() && Clock::now() - servo_.last_state() > kSilence + kTick && servo_force_n_ > 0.0)
            complain(row.tick, fmt::format("the servo's last word is {} N, and it has heard nothing", servo_force_n_));
        if (each_tick_) each_tick_(row.tick);
    }

    SimulatedTime time_;
    const haptable_model& model_;
    double limit_n_;
    Connection connection_;
    LocalStepper stepper_;
    Session servo_;
    std::unique_ptr<Path> path_;
    std::function<void(std::int64_t)> each_tick_;
    SessionOptions options_;
    Clock::time_point next_status_ = Clock::now() + kStatusPeriod;
    double servo_force_n_ = 0.0;                              ///< of the last message
    Eigen::Vector3d last_force_n_ = Eigen::Vector3d::Zero();  ///< the same
    Watched watched_;
};

}  // namespace

Watched run_faulty_session(const ServoScene& scene, const FaultPlan& plan, std::uint64_t seed, double seconds,
                           const std::function<void(std::int64_t)>& each_tick) {
    return WatchedSession(scene, plan, seed, seconds, each_tick).run();
}

}  // namespace haptable::test
