// SPDX-License-Identifier: GPL-2.0-or-later
// Runs a stroke on a scene's step and holds every tick to what docs/CONTACT.md, MOVING.md and TOOL.md
// promise, as geometry, tables in double and the laws of motion tell it. docs/STROKES.md lists the properties and the
// reasons for their tolerances.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/loaded_scene.hpp"
#include "host/strokes/law.hpp"
#include "host/strokes/motion.hpp"
#include "host/strokes/solid.hpp"
#include "host/strokes/stroke.hpp"

namespace haptable {

/// What a stroke can break.
enum class Fault : std::size_t {
    kOutside,   ///< contact while the finger is outside and sees its god-object
    kLost,      ///< no contact while the finger, which came from outside, is deep inside
    kForce,     ///< not finite, or above max_force
    kArea,      ///< area coordinates that do not add up to 1, or are not those of the god-object
    kLaw,       ///< not the mode's force
    kDrawn,     ///< force = "consistent": the drawn surface does not meet the finger
    kJump,      ///< a change of the force that neither the motion nor the release explains
    kEnergy,    ///< gives more than it stored
    kCone,      ///< friction: the force lies outside of its cone
    kBrake,     ///< with a release: a force that brakes more comes at once, and not by the slew
    kMomentum,  ///< of a free body: not what the fingers gave
    kPull,      ///< a tool's point, or one of many fingers, pulls the surface
};
inline constexpr std::array<std::string_view, 12> kFaultNames{
    "outside", "lost", "force", "area", "law", "drawn", "jump", "energy", "cone", "brake", "momentum", "pull"};
inline constexpr std::size_t kFaults = kFaultNames.size();
inline std::string_view name_of(Fault fault) { return kFaultNames[static_cast<std::size_t>(fault)]; }

/// What became of a stroke.
struct Verdict {
    std::array<int, kFaults> tick;                  ///< of the first fault of each kind; -1: none
    std::size_t contact_ticks = 0, both_ticks = 0;  ///< of any finger; of two at once, or more
    double most_stored_j = 0.0;
    double most_given_j = 0.0;  ///< where energy is judged: beyond what was stored when it began to be given
    double most_area = 0.0;     ///< by which the area coordinates miss a sum of 1
    bool clamped = false;       ///< met max_force
    std::size_t limits = 0;     ///< of walks, slides and boxes
    // By design (docs/CONTACT.md):
    std::size_t most_behind_ticks = 0;  ///< on end in contact, clearly outside, the god-object out of sight
    std::size_t passed = 0;             ///< motions of a tick clearly through the body, no contact before and after

    Verdict() { tick.fill(-1); }
    bool has(Fault fault) const { return tick[static_cast<std::size_t>(fault)] >= 0; }
    bool is_clean() const { return *std::max_element(tick.begin(), tick.end()) < 0; }
};

/// A tick of the scene.
using StepOfScene = void(SceneState& scene, const haptable_input in[], std::uint32_t now_us, haptable_output out[]);
inline void step_scene(SceneState& scene, const haptable_input in[], std::uint32_t now_us, haptable_output out[]) {
    scene.step(in, now_us, out);
}

/// A body's tables as the servo has them, for all god-objects, with friction and without; what strokes it, and what
/// judges that.
struct StrokedBody {
    explicit StrokedBody(SceneFiles files)
        : loaded(std::move(files)),
          solid(servo().vertex_m, servo().patch),
          law(loaded.tables(), servo()),
          maker(servo()) {}

    const ServoModel& servo() const { return loaded.servo(); }

    LoadedScene loaded;
    Solid solid;
    Law law;
    StrokeMaker maker;
};

/// One body in one mode.
struct Touched {
    const StrokedBody& on;
    const haptable_model& model;
    const haptable_pair_model* pair = nullptr;     ///< null: one finger, or a tool
    std::span<const haptable_tool_model> tools{};  ///< empty: the hand has fingers; else it holds the first
    std::span<const haptable_pair_model> pairs{};  ///< of which a stroke has one: by the number of fingers
    StepOfScene* step = &step_scene;               ///< a test may put a worse one in its place

    const haptable_body* body() const { return on.loaded.body(); }     ///< null: it is held
    const haptable_modes* modes() const { return on.loaded.modes(); }  ///< null: it follows at once
    int fingers() const { return pair != nullptr ? pair->finger_count : 1; }
    /// A tool, or three fingers and more.
    bool has_points() const { return !tools.empty() || fingers() > HAPTABLE_FINGERS; }
    /// What couples them.
    const haptable_pair_model& coupling() const { return tools.empty() ? *pair : *tool()->points.pair; }
    const haptable_tool_model* tool() const { return tools.empty() ? nullptr : tools.data(); }
    std::size_t contacts() const {
        return tools.empty() ? static_cast<std::size_t>(fingers()) : std::size_t{tool()->points.count};
    }
    /// With the tool, or as many fingers, as the stroke of that number has.
    Touched of_stroke(std::uint64_t number) const {
        Touched one = *this;
        if (!tools.empty())
            one.tools = tools.subspan(number % tools.size(), 1);
        else if (!pairs.empty())
            one.pair = &pairs[number % pairs.size()];
        return one;
    }
};

/// The stroke of that number. Where nothing holds the body the hands go after it.
Stroke make_stroke(const Touched& touched, std::uint64_t seed, std::uint64_t number);

/// What the judge tells of each finger, or point of a tool, in each tick, a line of CSV: where the finger is, as the
/// surface at rest has it; the god-object; limits so far; distance from the surface; the force felt, the mode's cut to
/// max_force, the change since the last tick; energy stored and, where it is judged, given so far; faults with spaces
/// between.
inline constexpr const char* kJudgedColumns =
    "tick,finger,x,y,z,contact,inside,sees_god,patch,alpha_0,alpha_1,alpha_2,god_x,god_y,god_z,limits,gap_m,"
    "force_n,law_n,change_n,stored_j,given_j,faults\n";

/// told: where not null, those lines are added to it.
Verdict judge(const Touched& touched, const Stroke& stroke, std::string* told = nullptr);

/// A stroke of fewer ticks that has the same fault: none of them can be left out, alone or with its neighbours, without
/// losing the fault or making the finger faster than it was (or than 5 m/s, whichever is more).
/// before: judge(touched, stroke).has(fault).
Stroke shrink(const Touched& touched, const Stroke& stroke, Fault fault);

}  // namespace haptable
