// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/page/live/ticks.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "codegen/model.hpp"

namespace haptable {

namespace {

constexpr std::chrono::seconds kServoGone{1};
constexpr std::chrono::milliseconds kOther{4};  // which the other finger's messages may be behind

std::array<std::int32_t, 3> ascending(std::array<std::int32_t, 3> nodes) {
    std::sort(nodes.begin(), nodes.end());
    return nodes;
}

bool copy_finite(const double* from, std::size_t count, float* into) {
    for (std::size_t i = 0; i < count; ++i) {
        into[i] = static_cast<float>(from[i]);
        if (!std::isfinite(into[i])) return false;
    }
    return true;
}

Eigen::Vector3d vector(const std::array<double, 3>& x) { return {x[0], x[1], x[2]}; }

}  // namespace

LiveTicks::LiveTicks(const Tables& tables, const ServoModel& servo, std::uint64_t hash, std::size_t fingers,
                     bool is_free, std::size_t modes)
    : tables_(tables),
      hash_(static_cast<std::int64_t>(hash)),
      vertex_(tables.position.size(), -1),
      side_(fingers),
      is_free_(is_free),
      modes_(modes) {
    for (std::size_t v = 0; v < servo.node.size(); ++v)
        vertex_[static_cast<std::size_t>(servo.node[v])] = static_cast<std::int32_t>(v);
    for (std::size_t p = 0; p < servo.patch.size(); ++p) {
        std::array<std::int32_t, 3> nodes{};
        for (std::size_t c = 0; c < 3; ++c) nodes[c] = servo.node[servo.patch[p][c]];
        patch_.emplace(ascending(nodes), static_cast<std::int32_t>(p));
    }
}

bool LiveTicks::is_followed(std::int64_t servo, std::int64_t model_hash, Clock::time_point now) {
    if (model_hash != hash_) {
        ++left_out_.other_tables;
        other_hash_ = static_cast<std::uint64_t>(model_hash);
        return false;
    }
    if (servo_ != 0 && servo != servo_ && now - heard_ < kServoGone) {
        ++left_out_.other_servo;
        return false;
    }
    return true;
}

void LiveTicks::take(const device_state& state, std::size_t finger) {
    if (finger < side_.size() && state.session == side_[finger].session)
        side_[finger].buttons = static_cast<std::uint32_t>(state.buttons);
}

void LiveTicks::take(const servo_force& force, std::size_t finger) {
    if (finger >= side_.size()) return;
    if (force.owner != force.session) {
        ++refusals_;
        return;
    }
    const bool is_second = servo_ != 0 && force.servo != servo_ && Clock::now() - heard_ < kServoGone;
    if (!is_second) side_[finger].force = force;  // the second one's contact is counted
}

void LiveTicks::take(const contact& load, std::size_t finger) {
    const Clock::time_point now = Clock::now();
    if (finger >= side_.size() || !is_followed(load.servo, load.model_hash, now)) return;
    Side& side = side_[finger];
    const servo_force& force = side.force;
    LiveTick tick;
    if (force.servo != load.servo || force.session != load.session || force.seq != load.seq) {
        ++lost_;
        return;
    }
    if (!copy_finite(force.force_n, 3, tick.force_n) || !fill_contact(force, load, tick)) {
        ++left_out_.damaged;
        return;
    }
    tick.state = static_cast<std::uint8_t>(force.servo_state);
    tick.faults = static_cast<std::uint32_t>(force.faults);
    if (load.session == side.session && load.servo == servo_ && load.seq > side.seq + 1)
        lost_ += load.seq - side.seq - 1;
    if (load.session != side.session) side.buttons = 0;
    tick.buttons = side.buttons;
    if (load.servo != servo_)
        for (Side& one : side_) one.last = {};
    servo_ = load.servo;
    side.session = load.session;
    side.seq = load.seq;
    heard_ = now;
    keep(joined_.add(finger, load.utime, tick));
    joined_since_ = now;
    side.last = tick;
    if (joined_.is_full(side_.size())) end_tick();
}

/// Who had no answer in the tick is as it was last.
void LiveTicks::keep(const std::optional<JoinedTick<LiveTick>::Tick>& joined) {
    if (!joined) return;
    if ((is_free_ && !pose_) || swung_.size() != modes_) {
        ++lost_;  // nobody has said where the body is
        return;
    }
    for (const Side& side : side_) ticks_.push_back(side.last);
    if (is_free_) poses_.push_back(*pose_);
    swings_.insert(swings_.end(), swung_.begin(), swung_.end());
}

void LiveTicks::take(const body_pose& pose, std::size_t) {
    if (!is_free_ || !is_followed(pose.servo, pose.model_hash, Clock::now())) return;
    if (!joined_.is_of(pose.utime)) end_tick();
    LivePose now;
    if (copy_finite(pose.centre_m, 3, now.centre_m) && copy_finite(pose.turn, 4, now.turn))
        pose_ = now;
    else
        ++left_out_.damaged;
}

void LiveTicks::take(const body_modes& modes, std::size_t) {
    if (modes_ == 0 || !is_followed(modes.servo, modes.model_hash, Clock::now())) return;
    if (!joined_.is_of(modes.utime)) end_tick();
    const std::vector<float> swung = swung_of(modes, modes_);
    if (swung.empty() || !std::all_of(swung.begin(), swung.end(), [](float q) { return std::isfinite(q); }))
        ++left_out_.damaged;
    else
        swung_ = swung;
}

std::vector<LiveTick> LiveTicks::ticks() {
    if (Clock::now() - joined_since_ >= kOther) end_tick();
    given_poses_ = std::exchange(poses_, {});
    given_swings_ = std::exchange(swings_, {});
    return std::exchange(ticks_, {});
}

/// False where a servo of these tables cannot have said that.
bool LiveTicks::fill_contact(const servo_force& force, const contact& load, LiveTick& tick) const {
    for (std::size_t a = 0; a < 3; ++a) tick.finger_m[a] = static_cast<float>(load.finger_m[a]);
    const bool touches = haptable_touches(force.servo_state) != 0;
    // Without a position there is no god-object either.
    std::copy_n(tick.finger_m, 3, tick.god_object_m);
    if (load.count == 0) return !touches;  // else a dent that the finger left
    if (load.count != 3 || !copy_finite(load.finger_m, 3, tick.finger_m) ||
        !copy_finite(load.god_object_m, 3, tick.god_object_m))
        return false;
    std::array<std::int32_t, 3> node{};
    for (std::size_t c = 0; c < 3; ++c) {
        node[c] = load.node[c];
        if (node[c] < 0 || static_cast<std::size_t>(node[c]) >= vertex_.size()) return false;
        tick.vertex[c] = vertex_[static_cast<std::size_t>(node[c])];
        if (!copy_finite(load.force_n[c].data(), 3, tick.nodal_force_n[c])) return false;
    }
    const auto patch = patch_.find(ascending(node));
    if (patch == patch_.end()) return false;
    tick.patch = patch->second;
    const std::array<double, 3> alpha = area_coordinates(node, load.god_object_m);
    return copy_finite(alpha.data(), 3, tick.alpha);
}

/// Area coordinates of a point on a patch, to rounding: the message does not carry them.
std::array<double, 3> LiveTicks::area_coordinates(const std::array<std::int32_t, 3>& node, const double x_m[3]) const {
    const auto at = [this](std::int32_t n) { return vector(tables_.position[static_cast<std::size_t>(n)]); };
    const Eigen::Vector3d x(x_m), a = at(node[0]), ab = at(node[1]) - a, ac = at(node[2]) - a;
    const Eigen::Vector3d normal = ab.cross(ac);
    const double beta = (x - a).cross(ac).dot(normal) / normal.squaredNorm();
    const double gamma = ab.cross(x - a).dot(normal) / normal.squaredNorm();
    return {1.0 - beta - gamma, beta, gamma};
}

}  // namespace haptable
