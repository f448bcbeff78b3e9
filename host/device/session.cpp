// SPDX-License-Identifier: GPL-2.0-or-later
// encoders -> state published -> answer -> force -> integrated to the next tick
#include "host/device/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>

#include "host/base/command_line.hpp"
#include "host/base/error.hpp"
#include "host/base/interrupt.hpp"
#include "host/device/simulated_driver.hpp"
#include "host/link/messages.hpp"

namespace haptable {

namespace {

constexpr std::int64_t kFlush_ticks = 100;

// A servo that has been silent for this long gives no force any more; the servo judges the device likewise.
constexpr std::chrono::milliseconds kSilence{20};

// A lost message is asked for again after this; a loaded machine may well stall for 50 ms.
constexpr std::chrono::milliseconds kResendAfter{100};

// In lockstep, a servo that has not answered so often in a row has gone: any may answer.
constexpr int kResendsToAny = 10;

void sleep_until(Clock::time_point deadline) {
    if (SimulatedTime* simulated = Clock::simulated()) {
        while (simulated->now() < deadline) simulated->leap(deadline);
        return;
    }
    const auto ns = std::chrono::duration_cast<std::chrono::nanoseconds>(deadline.time_since_epoch()).count();
    const timespec at{ns / 1'000'000'000, ns % 1'000'000'000};
    // steady_clock is CLOCK_MONOTONIC. A signal ends the sleep early; the caller looks at interrupted().
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
}

/// Throws BadCommandLine, which names `of`, where a clock of nanoseconds cannot count so far.
void require_countable(double seconds, const char* of) {
    constexpr double kMost_s = 1e9;
    if (!(seconds <= kMost_s))
        throw BadCommandLine(fmt::format("{}: {:.4g} s are more than {} s", of, seconds, kMost_s));
}

/// 0 s: until it is interrupted.
std::int64_t to_ticks(double seconds, const char* of) {
    if (seconds == 0.0) return std::numeric_limits<std::int64_t>::max();
    require_countable(seconds, of);
    return static_cast<std::int64_t>(std::ceil(seconds / kDeviceTick_s - 1e-6));
}

}  // namespace

DeviceSession::DeviceSession(const PointDevice& device, const Path& path, Connection& connection,
                             const SessionOptions& options, DeviceRecord* record)
    : DeviceSession(std::make_unique<SimulatedDriver>(device, path, DeviceMapping(options.map)), connection, options,
                    record) {}

DeviceSession::DeviceSession(std::unique_ptr<Driver> driver, Connection& connection, const SessionOptions& options,
                             DeviceRecord* record)
    : DeviceSession(*driver, connection, options, record) {
    own_ = std::move(driver);
}

DeviceSession::DeviceSession(Driver& driver, Connection& connection, const SessionOptions& options,
                             DeviceRecord* record)
    : driver_(driver),
      connection_(connection),
      options_(options),
      mapping_(options.map),
      record_(record),
      live_(options.tell) {
    if (options_.lockstep && !(options_.patience_s > 0.0))
        throw BadCommandLine("--patience: is 0, but in lockstep every tick waits for its answer: give it some seconds");
    require_countable(options_.patience_s, "--patience");
    reading_m_.fill(mapping_.to_body(driver_.read(0).position_m));
    state_.seq = -1;  // none yet
    state_.session = random_session();
    state_.mode = options_.lockstep ? device_state::SIMULATED : device_state::REAL_TIME;
    state_.model_hash = options_.model_hash;
    connection.subscribe<servo_status>(channel_of<servo_status>(), [this](const servo_status& status, std::int64_t) {
        if (options_.model_hash == 0 || status.model_hash == options_.model_hash) return;
        ++other_scene_;
        other_hash_ = status.model_hash;
    });
    pose_.session = state_.session;
    if (options_.has_tool)
        connection.subscribe<tool_wrench>(channel_of<tool_wrench>(),
                                          [this](const tool_wrench& wrench, std::int64_t) { wrench_ = wrench; });
    if (options_.faults.any())
        begin_faults();
    else
        connection.subscribe<servo_force>(channel_of<servo_force>(options_.finger),
                                          [this](const servo_force& force, std::int64_t) { on_force(force); });
}

void DeviceSession::begin_faults() {
    const FaultPlan& plan = options_.faults;
    if (options_.lockstep && (plan.corrupt > 0.0 || plan.clock_back.share > 0.0))
        throw Error(
            "--fault: corrupt and clock-back are not for --lockstep: a servo whose time the device sets would wait for "
            "that time for ever");
    faults_.emplace(Faults{{plan, options_.seed}, {plan, options_.seed + 1}, {plan, options_.seed + 2}});
    connection_.listen(channel_of<servo_force>(options_.finger),
                       [this](std::span<const std::uint8_t> bytes, std::int64_t) {
                           if (!faults_->gone) faults_->in.put(bytes, Clock::now());
                       });
}

// ---- the loop -----------------------------------------------------------------------------------------------------

/// One clock for all hands of a program.
class DeviceSession::Loop {
public:
    explicit Loop(const std::vector<DeviceSession*>& hands)
        : hands_(hands), connection_(hands[0]->connection_), options_(hands[0]->options_) {}

    void run() {
        const Clock::time_point begin = Clock::now();
        const std::int64_t ticks = tick_count();
        if (ticks > 0 && !is_over()) begin_session();
        for (std::int64_t tick = 1; tick < ticks && !is_over(); ++tick) {
            for (DeviceSession* hand : hands_) hand->begin_tick(tick);
            if (options_.lockstep) wait_for_answers();
            end_tick();
        }
        for (DeviceSession* hand : hands_)
            hand->report_.wall_s = std::chrono::duration<double>(Clock::now() - begin).count();
    }

private:
    std::int64_t tick_count() const {
        std::int64_t most = 0;
        for (const DeviceSession* hand : hands_) most = std::max(most, hand->tick_count());
        return most;
    }
    bool is_over() const {
        const auto has_ended = [](const DeviceSession* hand) { return hand->driver_.has_ended(); };
        return interrupted() || std::any_of(hands_.begin(), hands_.end(), has_ended);
    }
    bool is_unanswered() const {
        return std::any_of(hands_.begin(), hands_.end(),
                           [](const DeviceSession* hand) { return hand->is_unanswered(); });
    }

    /// The first answer may take until the servo is started: the clock starts with it.
    void begin_session() {
        const bool waits = options_.lockstep || options_.patience_s > 0.0;
        next_ = Clock::now();
        for (DeviceSession* hand : hands_) {
            hand->begin_tick(0);
            if (waits) wait_for_answers();
        }
        if (waits) next_ = Clock::now();
        end_tick();
    }

    void end_tick() {
        if (!options_.lockstep) {
            next_ += kTick;
            wait_until(next_);
            // Behind by more than a tick: go on from here, a burst of states would only bury the servo.
            if (Clock::now() > next_ + kTick) {
                for (DeviceSession* hand : hands_) ++hand->report_.late_ticks;
                next_ = Clock::now();
            }
        }
        for (DeviceSession* hand : hands_) hand->end_tick();
    }

    /// As Connection::handle_until, and what comes late, on purpose, comes then.
    bool handle_until(Clock::time_point deadline) {
        Clock::time_point due = Clock::time_point::max();
        for (const DeviceSession* hand : hands_) due = std::min(due, hand->due());
        const bool came = connection_.handle_until(std::min(deadline, due));
        for (DeviceSession* hand : hands_) hand->deliver();
        return came || due < deadline;
    }

    void wait_for_answers() {
        const Clock::time_point give_up = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                                             std::chrono::duration<double>(options_.patience_s));
        for (int resends = 0; !interrupted(); ++resends) {
            const Clock::time_point resend_at = std::min(Clock::now() + kResendAfter, give_up);
            while (is_unanswered() && handle_until(resend_at)) {
            }
            for (DeviceSession* hand : hands_) {
                if (!hand->is_unanswered()) continue;
                if (Clock::now() >= give_up) hand->give_up();
                hand->ask_again(resends);
            }
            if (!is_unanswered()) return;
        }
    }

    void wait_until(Clock::time_point next) {
        // Where messages are late, some still go out, or come in, behind the answer.
        const bool has_faults = options_.faults.any();
        while ((is_unanswered() || has_faults) && Clock::now() < next && !interrupted()) handle_until(next);
        sleep_until(next);
    }

    const std::vector<DeviceSession*>& hands_;
    Connection& connection_;
    const SessionOptions& options_;
    Clock::time_point next_{};
};

void run_together(const std::vector<DeviceSession*>& hands) { DeviceSession::Loop(hands).run(); }

DeviceReport DeviceSession::run() {
    run_together({this});
    return report_;
}

std::int64_t DeviceSession::tick_count() const {
    if (options_.seconds > 0.0) return to_ticks(options_.seconds, "--seconds");
    return to_ticks(driver_.duration_s(), "--path, as long as --speed, --hold and lengths make it");
}

// ---- a tick -------------------------------------------------------------------------------------------------------

void DeviceSession::begin_tick(std::int64_t tick) {
    const Reading reading = driver_.read(tick);
    const Eigen::Vector3d goal_m = mapping_.to_body(reading.goal_m);
    mapping_.follow(reading.position_m, (reading.buttons & kClutchButton) != 0, kDeviceTick_s, reading.wrist);
    if (mapping_.share() < 1.0) {
        ++report_.clutched_ticks;
        feel(body_force_n_, body_torque_n_m_);  // the ramp goes on though no answer comes
    }
    row_ = {tick,   mapping_.finger_m(),     mapping_.velocity_to_body(reading.velocity_m_s),
            goal_m, Eigen::Vector3d::Zero(), answered_};
    row_.tool = mapping_.tool();
    if (faults_) row_.encoder_m = faults_->device.see(row_.encoder_m, Clock::now());
    Eigen::Vector3d& oldest_m = reading_m_[static_cast<std::size_t>(tick) % kWindow_ticks];
    const Eigen::Vector3d velocity_m_s =
        (row_.encoder_m - oldest_m) / (static_cast<double>(kWindow_ticks) * kDeviceTick_s);
    oldest_m = row_.encoder_m;
    state_.utime = options_.lockstep ? tick * kTick.count() : utime_now();
    if (faults_) state_.utime = faults_->device.clock(state_.utime);
    state_.seq = tick;
    state_.buttons = reading.buttons;
    Eigen::Map<Eigen::Vector3d>(state_.position_m) = row_.encoder_m;
    Eigen::Map<Eigen::Vector3d>(state_.velocity_m_s) = velocity_m_s;
    const Eigen::Quaterniond& turn = row_.tool.turn;
    pose_.utime = state_.utime;
    pose_.seq = tick;
    Eigen::Map<Eigen::Vector4d>(pose_.turn) = Eigen::Vector4d(turn.w(), turn.x(), turn.y(), turn.z());
    Eigen::Map<Eigen::Vector3d>(pose_.spin_rad_per_s) = row_.tool.spin_rad_s;
    ++report_.ticks;
    publish();
}

void DeviceSession::publish() {
    const Clock::time_point now = Clock::now();
    published_[static_cast<std::size_t>(state_.seq) % kKept_ticks] = now;
    if (options_.has_tool) connection_.publish(channel_of<hand_pose>(), pose_);
    if (!faults_) return connection_.publish(channel_of<device_state>(options_.finger), state_);
    std::array<std::uint8_t, FaultyLane::kMost_bytes> bytes{};
    const int size = state_.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    faults_->gone = faults_->device.is_gone(now);
    if (!faults_->gone) faults_->out.put({bytes.data(), static_cast<std::size_t>(size)}, now);
    deliver();
}

/// What is due on both faulty lanes.
void DeviceSession::deliver() {
    if (!faults_) return;
    const Clock::time_point now = Clock::now();
    faults_->out.deliver(now, [this](std::span<const std::uint8_t> bytes) {
        connection_.send(channel_of<device_state>(options_.finger), bytes);
    });
    faults_->in.deliver(now, [this](std::span<const std::uint8_t> bytes) {
        servo_force force{};
        if (decode_whole(bytes, force)) on_force(force);
    });
}

/// When a faulty lane has something to deliver.
Clock::time_point DeviceSession::due() const {
    return faults_ ? std::min(faults_->out.due(), faults_->in.due()) : Clock::time_point::max();
}

/// True for the servo that this device belongs to, or of the first that answers it.
bool DeviceSession::is_for_us(const servo_force& force) {
    const bool other_tables = state_.model_hash != 0 && force.model_hash != state_.model_hash;
    const bool other_servo = state_.servo != 0 && force.servo != state_.servo;
    if (force.session != state_.session) {
        ++report_.other_device_answers;
    } else if (other_tables || other_servo) {
        ++report_.foreign_answers;
    } else if (force.owner != state_.session) {
        ++report_.refused_answers;
        other_owner_ = force.owner;
    } else {
        return true;
    }
    return false;
}

Clock::duration DeviceSession::age_of(const servo_force& force, Clock::time_point now) const {
    const std::int64_t oldest = state_.seq - static_cast<std::int64_t>(kKept_ticks) + 1;
    return now - published_[static_cast<std::size_t>(std::max(force.seq, oldest)) % kKept_ticks];
}

/// What came before it, of the same servo; without it none.
Eigen::Vector3d DeviceSession::torque_of(const servo_force& force) const {
    const bool is_its = wrench_.session == force.session && wrench_.servo == force.servo && wrench_.seq == force.seq;
    return is_its ? Eigen::Vector3d(wrench_.torque_n_m) : Eigen::Vector3d(Eigen::Vector3d::Zero());
}

void DeviceSession::on_force(const servo_force& force) {
    if (!is_for_us(force) || force.seq < 0 || force.seq > state_.seq || force.seq < answered_) return;
    if (force.seq == answered_) {
        // The second answer to a state is none, but for a servo's last word.
        if (force.servo_state == servo_force::SILENT) feel(Eigen::Vector3d::Zero());
        return;
    }
    const Clock::time_point now = Clock::now();
    const Clock::duration age = age_of(force, now);
    report_.latency.add(to_us(age));
    // Who has let go takes nothing of before: the servo's contact ends with the states that followed.
    if (!options_.lockstep && (age >= kSilence || force.seq < first_)) {
        ++report_.stale_answers;
        return;
    }
    // From now on only this servo: a second one would pull the finger to and fro.
    state_.model_hash = force.model_hash;
    state_.servo = force.servo;
    if (force.servo_state == servo_force::CONTACT || force.servo_state == servo_force::LIMITED) ++report_.contact_ticks;
    if (const auto event = events_.note(force)) live_.say(fmt::format("tick {}: {}", force.seq, *event));
    answered_ = force.seq;
    asked_ = now - age;
    silent_ = false;
    // Until it came the old force acted. In lockstep an answer takes no time.
    const Clock::time_point begun = published_[static_cast<std::size_t>(state_.seq) % kKept_ticks];
    if (!options_.lockstep) driver_.advance(row_.tick, to_us(now - begun) / 1000.0);
    feel(Eigen::Vector3d(force.force_n), torque_of(force));
    report_.largest_torque_n_m = std::max(report_.largest_torque_n_m, body_torque_n_m_.norm());
    report_.largest_force_n = std::max(report_.largest_force_n, driver_.force_n().norm());
}

/// Force and torque of the body's, as the clutch lets them through.
void DeviceSession::feel(const Eigen::Vector3d& body_n, const Eigen::Vector3d& body_n_m) {
    body_force_n_ = body_n;
    body_torque_n_m_ = body_n_m;
    driver_.set_force(mapping_.to_motors(body_n));
    driver_.set_torque(mapping_.torque_to_motors(body_n_m));
}

void DeviceSession::ask_again(int resends) {
    if (resends == kResendsToAny) forget_servo();
    ++report_.resent;
    publish();
}

void DeviceSession::give_up() const {
    throw Error(
        fmt::format("no answer to state {} within {} s on {}: start build/<name>/servo --lcm on the same machine and "
                    "LCM_DEFAULT_URL ({}{})",
                    state_.seq, options_.patience_s, connection_.url(), why_none(),
                    options_.finger == 0 || report_.refused_answers > 0
                        ? ""
                        : "; as a second finger, which only a scene with [contact] fingers = 2 has"));
}

void DeviceSession::end_tick() {
    row_.answered_tick = answered_;
    if (answered_ < state_.seq) ++report_.missed;
    drop_stale_force();
    if (!silent_ && !options_.lockstep) report_.force_age.add(to_us(Clock::now() - asked_));
    driver_.advance(row_.tick, 1.0);
    row_.force_n = mapping_.turned_to_body(driver_.force_n());
    row_.torque_n_m = mapping_.share() * body_torque_n_m_;
    if (options_.watch) options_.watch(row_);
    if (row_.tick % kFlush_ticks == 0) tell();
    if (record_ == nullptr) return;
    record_->add(row_);
    if (row_.tick % kFlush_ticks == 0) record_->flush();
}

void DeviceSession::drop_stale_force() {
    // What acts is as old as the state that it answers.
    if (silent_ || options_.lockstep || Clock::now() - asked_ < kSilence) return;
    silent_ = true;
    ++report_.silences;
    feel(Eigen::Vector3d::Zero());
    first_ = state_.seq + 1;
    forget_servo();
}

/// Tells who else is on the channel, and of silence.
void DeviceSession::tell() {
    const Clock::time_point now = Clock::now();
    live_.look("silences", report_.silences, now,
               [] { return "the servo was silent for 20 ms: no force until it answers again"; });
    live_.look("foreign_answers", report_.foreign_answers, now,
               [] { return "a second servo, or one of another scene, is on the channel: it moves nothing here"; });
    live_.look("other_scene", other_scene_, now, [this] { return of_other_scene(); });
    live_.look("refused_answers", report_.refused_answers, now, [this] {
        return fmt::format("the servo belongs to another device, session {:016x}: no force until that one ends",
                           static_cast<std::uint64_t>(other_owner_));
    });
    live_.look("other_device_answers", report_.other_device_answers, now,
               [] { return "a second device is on the channel: its forces are not felt here"; });
}

/// Any servo may answer from now on: one that is started anew is another one, and may have newer tables.
void DeviceSession::forget_servo() {
    state_.servo = 0;
    state_.model_hash = options_.model_hash;
}

std::string DeviceSession::of_other_scene() const {
    return fmt::format(
        "the servo on the channel runs the tables {:016x}, this scene's are {:016x}: it gives no force "
        "here; start this scene's servo, or build it again (make scene)",
        static_cast<std::uint64_t>(other_hash_), static_cast<std::uint64_t>(options_.model_hash));
}

std::string DeviceSession::why_none() const {
    if (report_.refused_answers > 0)
        return fmt::format("a servo answers, but belongs to the device with session {:016x}: end that one first",
                           static_cast<std::uint64_t>(other_owner_));
    if (other_scene_ > 0) return of_other_scene();
    if (report_.stale_answers > 0) return fmt::format("{} answers came, but later than 20 ms", report_.stale_answers);
    return fmt::format("{} answers came from servos of other models", report_.foreign_answers);
}

}  // namespace haptable
