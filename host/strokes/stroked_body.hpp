// SPDX-License-Identifier: GPL-2.0-or-later
// One body with one of the three forces, held or free, ringing or not: its tables, its servo in memory, and what judges
// them.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "host/base/modes.hpp"
#include "host/inverse/cholmod_inverse.hpp"
#include "host/scene/scene.hpp"
#include "host/strokes/judge.hpp"

namespace haptable {

/// How a body moves as a whole (HAPTABLE_RIGID_MOVERS), and whether it rings (docs/MOVING.md).
struct BodyKind {
    unsigned motion = 0;  ///< 0: it is held; else 1 + enum haptable_rigid_motion
    bool rings = false;

    bool operator==(const BodyKind&) const = default;
    std::string name() const;
};
/// All of them. Those of one stiffness matrix, which is factorised once, are beside each other.
inline constexpr auto kBodyKinds = [] {
    std::array<BodyKind, std::size_t{2} * (1 + HAPTABLE_RIGID_MOTIONS)> kinds{};
    for (unsigned i = 0; i < kinds.size(); ++i) kinds[i] = {i / 2, i % 2 == 1};
    return kinds;
}();

/// A way of touching (docs/CONTACT.md).
struct TouchMode {
    ForceLaw force = ForceLaw::kInterpolated;
    GodObject god_object = GodObject::kNearest;
    bool friction = false;
    int fingers = 1;
    BodyKind body = {};
    bool tool = false;  ///< of a hand, in place of its finger, on a body at rest

    /// Of three to eight, the number that the mode has at the most.
    bool has_hands() const { return fingers > HAPTABLE_FINGERS; }

    std::string name() const {
        return std::string(word(force)) + "-" + word(god_object) + (friction ? "-friction" : "") +
               (fingers == 2 ? "-two" : "") + (has_hands() ? "-hands" : "") + (tool ? "-tool" : "") + body.name();
    }
    bool is_coupled() const { return fingers > 1 || tool; }
};

/// All: force by force. Tools and hands have forces that a compliance gives.
std::vector<TouchMode> all_modes();

/// The scene touched so: friction 0.3 and 0.2, eight modes, 1,000 kg/m^3, and what else a scene has by default.
Scene in_mode(Scene scene, const TouchMode& mode);

/// A body's tables for each force, in folders of their own; what is there is not computed again. K is factorised once,
/// and S_i are those of one force for all. In the order of every<ForceLaw>() they take least: the inversion for edges
/// gives S_i too.
class BodyTables {
public:
    /// A tick is judged by these tables themselves: their error is not what is judged here, and single precision is
    /// enough.
    static constexpr double kTolerance = 1e-4;

    BodyTables(Scene scene, std::filesystem::path folder) : scene_(std::move(scene)), folder_(std::move(folder)) {}

    /// Tables for a mode's force, fingers and body. Throws Error as precompute does.
    SceneFiles with(const TouchMode& mode);
    /// CPU seconds that the tables took which are there, when they were computed.
    double cpu_s() const;

private:
    std::filesystem::path folder_of(const TouchMode& mode) const;

    Scene scene_;
    std::filesystem::path folder_;
    CholmodInverse inverse_;
};

/// Tools of 2 to 16 points: spheres, discs, and points as a hand may put them, from one mask's size to a sixth of the
/// body's.
std::vector<ToolTables> random_tools(const StrokedBody& body, const Scene& scene);

/// The servo's models of a body in one mode.
class StrokedModel {
public:
    /// With these options, but for the force. body: it must outlive this object. tools: a stroke has one of them. Of
    /// more than two fingers a stroke has three to so many.
    StrokedModel(const StrokedBody& body, const ContactOptions& contact, const std::vector<ToolTables>& tools = {});
    StrokedModel(const StrokedModel&) = delete;
    StrokedModel& operator=(const StrokedModel&) = delete;

    Touched touched() const {
        return {body_, model_, !pairs_.empty() && tools_.empty() ? &pairs_.back() : nullptr, tools_, pairs_};
    }

private:
    const StrokedBody& body_;
    haptable_model model_;
    std::vector<haptable_pair_model> pairs_;  ///< by the number of fingers
    std::vector<ToolPoints> points_;          ///< [t]
    std::vector<haptable_tool_model> tools_;  ///< [t]
};

}  // namespace haptable
