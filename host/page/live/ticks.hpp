// SPDX-License-Identifier: GPL-2.0-or-later
// A session's messages as the ticks that a page draws.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/link/clock.hpp"
#include "host/link/joined.hpp"
#include "host/link/messages.hpp"
#include "host/tables/tables.hpp"

namespace haptable {

struct ServoModel;

/// A finger's tick as the page's engine reads it: struct page_tick of host/page/wasm/page.c. SI.
struct LiveTick {
    std::uint32_t state = 0;                            ///< enum haptable_state
    std::int32_t patch = -1, vertex[3] = {-1, -1, -1};  ///< of the servo's tables; -1 without contact
    float finger_m[3]{}, alpha[3]{}, god_object_m[3]{}, force_n[3]{}, nodal_force_n[3][3]{};
    std::uint32_t buttons = 0, faults = 0;
};
static_assert(sizeof(LiveTick) == 112);

/// Where a body that nothing holds is, as the page's engine reads it: struct page_pose. Its frame is that of a tick's
/// god-objects and loads.
struct LivePose {
    float centre_m[3]{}, turn[4]{1.0F};
};
static_assert(sizeof(LivePose) == 28);

/// What is no tick, by why.
struct LiveLeftOut {
    std::int64_t other_tables = 0;  ///< of another scene's servo, or of older tables
    std::int64_t other_servo = 0;   ///< of a second one, while the first speaks
    std::int64_t damaged = 0;       ///< that no servo of these tables can have sent
    std::int64_t sum() const { return other_tables + other_servo + damaged; }
};

/// Joins each servo_force to its contact, and the fingers of a tick, whose messages have one time. Follows one servo,
/// until that has been silent for a second.
class LiveTicks {
public:
    /// `servo` is the model of `tables`, `hash` that of its bytes (model_in_memory); fingers: of the scene, 1 or 2;
    /// is_free: nothing holds the body; modes: by which it rings.
    LiveTicks(const Tables& tables, const ServoModel& servo, std::uint64_t hash, std::size_t fingers = 1,
              bool is_free = false, std::size_t modes = 0);

    /// finger: 0 or 1; one that the scene has not is passed over.
    void take(const servo_force& force, std::size_t finger = 0);
    void take(const contact& load, std::size_t finger = 0);
    /// Before the contacts of its tick.
    void take(const body_pose& pose, std::size_t = 0);
    void take(const body_modes& modes, std::size_t = 0);
    /// Takes what the device that has the servo holds down.
    void take(const device_state& state, std::size_t finger = 0);

    /// Those that were joined since the last call: [ticks, fingers]. Who had no answer in a tick is as it was last.
    std::vector<LiveTick> ticks();
    /// Poses of those that ticks() gave last: [ticks], where nothing holds the body; else none.
    const std::vector<LivePose>& poses() const { return given_poses_; }
    /// Modes of the same: [ticks, modes], how far each has swung.
    const std::vector<float>& swings() const { return given_swings_; }
    /// When the last tick came; the epoch's begin, where none did.
    Clock::time_point heard() const { return heard_; }
    const LiveLeftOut& left_out() const { return left_out_; }
    /// Ticks of which a message was not heard.
    std::int64_t lost() const { return lost_; }
    /// Times that a servo told another device that it is not its.
    std::int64_t refusals() const { return refusals_; }
    /// Hash of the last message of other tables.
    std::uint64_t other_hash() const { return other_hash_; }

private:
    /// What is known of a finger.
    struct Side {
        servo_force force{};                 ///< the last one that was for its device
        std::int64_t session = 0, seq = -1;  ///< of the last tick
        std::uint32_t buttons = 0;
        LiveTick last;  ///< of the servo that is followed
    };
    bool is_followed(std::int64_t servo, std::int64_t model_hash, Clock::time_point now);
    bool fill_contact(const servo_force& force, const contact& load, LiveTick& tick) const;
    void keep(const std::optional<JoinedTick<LiveTick>::Tick>& joined);
    void end_tick() { keep(joined_.end()); }
    std::array<double, 3> area_coordinates(const std::array<std::int32_t, 3>& node, const double x_m[3]) const;

    const Tables& tables_;
    std::int64_t hash_;
    std::vector<std::int32_t> vertex_;                           ///< [N] of each mesh node; -1: none
    std::map<std::array<std::int32_t, 3>, std::int32_t> patch_;  ///< by ascending mesh nodes
    std::vector<Side> side_;
    JoinedTick<LiveTick> joined_;  ///< whose other finger may come yet
    Clock::time_point joined_since_{};
    std::int64_t servo_ = 0;  ///< of the last tick
    Clock::time_point heard_{};
    std::vector<LiveTick> ticks_;
    bool is_free_;
    std::optional<LivePose> pose_;
    std::vector<LivePose> poses_, given_poses_;
    std::size_t modes_;
    std::vector<float> swung_, swings_, given_swings_;
    LiveLeftOut left_out_;
    std::int64_t lost_ = 0, refusals_ = 0;
    std::uint64_t other_hash_ = 0;
};

}  // namespace haptable
