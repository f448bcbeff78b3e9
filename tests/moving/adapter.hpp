// SPDX-License-Identifier: GPL-2.0-or-later
// A body that is held or free, rings or not, under one finger or two, stepped by a tick; and what of its state the laws
// of physics speak of, in double.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>

#include "codegen/loaded_scene.hpp"
#include "host/scene/scene.hpp"
#include "host/strokes/motion.hpp"

namespace haptable::test {

using TwoPoints = std::array<Eigen::Vector3d, 2>;

/// The tables of one scene: made once, touched in many ways.
class MovingTables {
public:
    /// Runs precompute. Throws Error as it does.
    explicit MovingTables(Scene scene);

    const Scene& scene() const { return scene_; }
    const LoadedScene& loaded() const { return loaded_; }
    bool is_free() const { return loaded_.body() != nullptr; }
    const Rigid& rigid() const { return rigid_; }  ///< of a held body all zero
    /// The largest of any point, as felt.
    double stiffness_n_per_m() const { return loaded_.servo().stiffness.felt_n_per_m; }
    double size_m() const { return double(loaded_.servo().tolerance_m) * 0x1p20; }  ///< the diagonal

private:
    Scene scene_;
    LoadedScene loaded_;
    Rigid rigid_;
};

/// How a session touches it, and what else acts on a free body.
struct Touching {
    int fingers = 1;
    GodObject god_object = GodObject::kLeastEnergy;
    double friction = 0.0;
    double max_force_n = 1e6;
    double release_n_per_ms = 0.0;
    bool by_scene = false;  ///< all but the fingers as the scene says
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
    MovingSession(const MovingSession&) = delete;
    MovingSession& operator=(const MovingSession&) = delete;

    /// One tick; [fingers] positions, m, rounded to float. Felt are of the pose before it.
    void step(const TwoPoints& finger_m);
    const Felt& felt(int finger) const { return felt_[std::size_t(finger)]; }
    bool touches() const { return felt_[0].touches || felt_[1].touches; }
    bool both_touch() const { return felt_[0].touches && felt_[1].touches; }
    Eigen::Vector3d force_n() const { return felt_[0].force_n + felt_[1].force_n; }  ///< on both hands
    bool is_sound() const;                                                           ///< all are numbers, without fault
    bool is_sound(int finger) const;                                                 ///< likewise
    /// Of the last tick.
    const haptable_output& out(int finger) const { return out_[std::size_t(finger)]; }
    bool is_on_floor() const { return scene_->body()->on_floor != 0; }

    /// Of a free body by the end of the last tick; of one that is held none.
    Motion motion() const { return tables_.is_free() ? motion_of(*scene_->body(), tables_.rigid()) : Motion(); }
    /// Gives it that velocity, and that spin along body axes.
    void put_motion(const Eigen::Vector3d& velocity_m_per_s, const Eigen::Vector3d& spin_rad_per_s);
    /// A world position in body coordinates, at the present pose.
    Eigen::Vector3d to_body(const Eigen::Vector3d& world_m) const;
    Eigen::Vector3d to_world(const Eigen::Vector3d& body_m) const;
    /// J, in double from that state: of motion, weight and suspension, without the floor's springs.
    double motion_j() const;
    /// One tick of which the ledger takes note.
    void step(const TwoPoints& finger_m, Ledger& ledger);

private:
    const MovingTables& tables_;
    Touching touching_;
    haptable_model model_{};
    haptable_pair_model pair_{};
    haptable_body body_{};
    mutable std::optional<SceneState> scene_;
    std::array<Felt, 2> felt_;
    std::array<haptable_output, 2> out_{};
    std::uint32_t now_us_ = 0;
};

/// A ledger of this body, and what a session made beyond a wall's part and rounding: 0 J at the most.
inline Ledger ledger_of(const MovingTables& tables) {
    return {tables.stiffness_n_per_m(), tables.is_free() ? &tables.rigid() : nullptr};
}
inline double made_j(const Ledger& ledger) {
    return ledger.risen_j() - 64 * 0x1p-24 * ledger.largest_j() - ledger.rounded_j();
}

/// What two hands get along their ways, each tick's by the mean of its forces.
class Round {
public:
    /// After each tick.
    void add(const MovingSession& session);
    double given_j() const { return given_j_; }
    double paid_j() const { return paid_j_; }            ///< the most that the hands had paid at once
    double way_m() const { return way_m_; }              ///< of both, in the last tick
    double step_n() const { return step_n_; }            ///< of the force that changed more in it
    double most_step_n() const { return most_step_n_; }  ///< so far

private:
    std::array<Felt, 2> last_;
    bool has_begun_ = false;
    double given_j_ = 0.0, paid_j_ = 0.0, way_m_ = 0.0, step_n_ = 0.0, most_step_n_ = 0.0;
};

}  // namespace haptable::test
