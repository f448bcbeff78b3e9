// SPDX-License-Identifier: GPL-2.0-or-later
// Runs a stroke on the servo and holds every tick to what docs/CONTACT.md promises, as geometry and tables in double
// tell it. docs/STROKES.md lists the properties and the reasons for their tolerances.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/haptable_scene.h"
#include "host/strokes/law.hpp"
#include "host/strokes/solid.hpp"
#include "host/strokes/stroke.hpp"

namespace haptable {

/// What a stroke can break.
enum class Fault : std::size_t {
    kOutside,  ///< contact while the finger is outside and sees its god-object
    kLost,     ///< no contact while the finger, which came from outside, is deep inside
    kForce,    ///< not finite, or above max_force
    kLaw,      ///< not the mode's force
    kDrawn,    ///< force = "consistent": the drawn surface does not meet the finger
    kJump,     ///< a change of the force that neither the motion nor the release explains
    kEnergy,   ///< least energy: gives more than it stored
    kCone,     ///< friction: the force lies outside of its cone
    kBrake,    ///< with a release: a force that brakes more comes at once, and not by the slew
};
inline constexpr std::array<std::string_view, 9> kFaultNames{"outside", "lost",   "force", "law",  "drawn",
                                                             "jump",    "energy", "cone",  "brake"};
inline constexpr std::size_t kFaults = kFaultNames.size();
inline std::string_view name_of(Fault fault) { return kFaultNames[static_cast<std::size_t>(fault)]; }

/// What became of a stroke.
struct Verdict {
    std::array<int, kFaults> tick;  ///< of the first fault of each kind; -1: none
    std::size_t contact_ticks = 0;
    double most_stored_j = 0.0;
    double most_given_j = 0.0;  ///< least energy: beyond what was stored when it began to be given
    bool clamped = false;       ///< met max_force
    // By design (docs/CONTACT.md):
    std::size_t most_behind_ticks = 0;  ///< on end in contact, clearly outside, the god-object out of sight
    std::size_t passed = 0;             ///< motions of a tick clearly through the body, no contact before and after
    haptable_counters counters{};

    Verdict() { tick.fill(-1); }
    bool has(Fault fault) const { return tick[static_cast<std::size_t>(fault)] >= 0; }
    bool is_clean() const;
};

/// One body in one mode.
struct Touched {
    const Solid& solid;
    const Law& law;
    const ServoModel& servo;
    const haptable_model& model;
    decltype(&haptable_servo_step) step = &haptable_servo_step;  ///< the servo; a test may put a worse one in its place
};

/// One tick as the judge saw it.
struct Judged {
    bool contact, inside, sees_god;
    SurfacePoint at;  ///< the god-object, where there is contact
    Eigen::Vector3d god_m;
    std::size_t limits;               ///< counted so far
    double gap_m;                     ///< of the finger from the surface
    double force_n, law_n, change_n;  ///< felt; the mode's, cut to max_force; since the last tick
    double stored_j, given_j;         ///< at the god-object; least energy: so far
    std::string faults;               ///< kinds, with spaces between
};

/// ticks: where not null, what the judge saw is added to it.
Verdict judge(const Touched& touched, const Stroke& stroke, std::vector<Judged>* ticks = nullptr);

}  // namespace haptable
