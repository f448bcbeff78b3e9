// SPDX-License-Identifier: GPL-2.0-or-later
// The one place where the tests of bodies that move know the firmware's names: a body that is held or free, rings or
// not, under one finger or two, stepped by a tick; and what of its state the laws of physics speak of, in double.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "codegen/model.hpp"
#include "host/scene/scene.hpp"
#include "host/strokes/motion.hpp"
#include "host/tables/modes.hpp"
#include "host/tables/tables.hpp"

namespace haptable::test {

/// The tables of one scene: read once, touched in many ways.
class MovingTables {
public:
    /// Runs precompute. Throws Error as it does.
    explicit MovingTables(Scene scene);
    ~MovingTables();
    MovingTables(const MovingTables&) = delete;
    MovingTables& operator=(const MovingTables&) = delete;

    const Scene& scene() const { return scene_; }
    const Tables& tables() const { return tables_; }
    const ServoModel& servo() const { return servo_; }
    bool is_free() const { return rigid_.has_value(); }
    const Rigid& rigid() const { return *rigid_; }  ///< before: is_free()
    /// None where it does not ring.
    const std::optional<ModeTables>& body_modes() const { return body_modes_; }
    double stiffness_limit_n_per_m() const;  ///< the largest of any point, as felt
    double size_m() const;                   ///< the diagonal

private:
    friend class MovingSession;
    struct Firmware;

    Scene scene_;
    Tables tables_;
    ServoModel servo_;
    std::optional<Rigid> rigid_;
    std::optional<ModeTables> body_modes_;
    std::unique_ptr<Firmware> firmware_;
};

/// How a session touches it, and what else acts on a free body.
struct Touching {
    int fingers = 1;
    GodObject god_object = GodObject::kLeastEnergy;
    double friction = 0.0;
    double max_force_n = 1e6;
    double release_n_per_ms = 0.0;
    bool by_scene = false;  ///< all of the above as the scene says
    // A free body's; world axes.
    Eigen::Vector3d gravity_m_per_s2 = Eigen::Vector3d::Zero();
    bool floor = false;           ///< below the body's lowest point
    double floor_friction = 0.5;  ///< Coulomb's
    double hang_n_per_m = 0.0;    ///< a suspension of the centre
    double hang_n_s_per_m = 0.0;  ///< and its damper
    double twist_n_m = 0.0;       ///< of turning, in N m/rad for small angles
    double twist_n_m_s = 0.0;     ///< and its damper
};

class MovingSession {
public:
    MovingSession(const MovingTables& tables, const Touching& touching);
    ~MovingSession();
    MovingSession(const MovingSession&) = delete;
    MovingSession& operator=(const MovingSession&) = delete;

    /// One tick; [fingers] positions, m, rounded to float. Felt are of the pose before it.
    void step(const std::array<Eigen::Vector3d, 2>& finger_m);
    const Felt& felt(int finger) const { return felt_[static_cast<std::size_t>(finger)]; }

    /// Of a free body by the end of the last tick.
    Motion motion() const;
    /// Gives it that velocity, and that spin along body axes.
    void put_motion(const Eigen::Vector3d& velocity_m_per_s, const Eigen::Vector3d& spin_rad_per_s);
    /// A world position in body coordinates, at the present pose.
    Eigen::Vector3d to_body(const Eigen::Vector3d& world_m) const;
    Eigen::Vector3d to_world(const Eigen::Vector3d& body_m) const;
    /// J, in double from that state: of motion, weight and suspension, without the floor's springs.
    double motion_j() const;
    /// 1/2 (q'^2 + omega^2 q^2) of all modes; 0 where it does not ring.
    double modes_j() const;
    /// Stored by all contacts in the last tick.
    double contact_j() const;
    /// The last tick; before: of a free body, as it was before the step.
    void note(Ledger& ledger, const Motion& before) const;
    double floor_m() const { return floor_m_; }

private:
    struct Firmware;

    const MovingTables& tables_;
    Touching touching_;
    double floor_m_ = 0.0;
    std::array<Felt, 2> felt_;
    std::unique_ptr<Firmware> firmware_;
};

}  // namespace haptable::test
