// SPDX-License-Identifier: GPL-2.0-or-later
// The bodies and modes that the contact bench touches, and the finger that touches them.
#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <memory>

#include "firmware/haptable_scene.h"
#include "host/bench/subject.hpp"
#include "host/scene/scene.hpp"

namespace haptable {

/// How a scene is touched.
struct ContactMode {
    ForceLaw force;
    GodObject god_object;
};

inline constexpr auto kContactModes = [] {
    std::array<ContactMode, every<ForceLaw>().size() * every<GodObject>().size()> modes{};
    std::size_t i = 0;
    for (const GodObject god_object : every<GodObject>())
        for (const ForceLaw force : every<ForceLaw>()) modes[i++] = {force, god_object};
    return modes;
}();

/// The scene in that mode, precomputed below `build`, and ready to be touched. `mask_radius_m` counts for masks alone.
std::unique_ptr<Subject> touched_as(Scene scene, const ContactMode& mode, double mask_radius_m,
                                    const std::filesystem::path& build);

/// The paper's cube; of more than 9 nodes a side only the middle of its top may be touched.
Scene contact_cube(int nodes_per_side, double poisson);

/// The model without what is added to its force: no limit, no release.
haptable_model bare(haptable_model model);

/// A finger in double on a model in float, one position a tick.
class BenchFinger {
public:
    explicit BenchFinger(const haptable_model& model);
    void begin();                                    ///< a new session
    Eigen::Vector3d to(const Eigen::Vector3d& x_m);  ///< the force of that tick, N
    bool touches() const { return out_.state == HAPTABLE_CONTACT; }
    double energy() const;       ///< stored, 1/2 u . f, J; 0 without contact
    Eigen::Vector3d at() const;  ///< as the servo saw it, m

private:
    haptable_model model_;
    haptable_room room_{};
    haptable_servo& servo_ = room_.fingers.servo[0];
    haptable_output out_{};
    std::array<float, 3> finger_m_{};
};

}  // namespace haptable
