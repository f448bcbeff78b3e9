// SPDX-License-Identifier: GPL-2.0-or-later
// min W(u)  where  w^T u = d:  how a body that stiffens resists a finger
//
// The finger's load has fixed shares w, and its weighted mean displacement d is given: of the linear body that is
// F = C^-1 d. Minimised by L-BFGS (Nocedal 1980) in the metric of the linear body's K, whose factor is there: no
// tangent is assembled.
#pragma once

#include <deque>
#include <optional>
#include <span>

#include "host/body/small_strain.hpp"
#include "host/fem/hyperelastic.hpp"

namespace haptable {

/// A finger on one body, pressed by steps; each begins where the last one rested.
class Indentation {
public:
    /// The solver's K is the mesh's linear one, of its unknown nodes. All must outlive this.
    Indentation(const Hyperelastic& body, const LinearSolver& solver, std::span<const std::int32_t> unknown,
                const NodeWeights& load);

    /// N: what the finger is resisted with at a displacement d, m. None where no rest was found: an element turned
    /// over, or kMostSteps were too few.
    std::optional<Eigen::Vector3d> force_n(const Eigen::Vector3d& d);
    /// The linear body's: C^-1, N/m.
    const Eigen::Matrix3d& stiffness_n_per_m() const { return stiffness_; }
    /// J: W of the last displacement that rested.
    double stored_j() const { return rest_.energy_j; }

private:
    static constexpr int kMostSteps = 400;  ///< of one displacement
    static constexpr int kHalvings = 3;     ///< of a displacement's step, where no rest was found

    struct State {
        Eigen::VectorXd x;         ///< [3n] displacements
        Eigen::VectorXd gradient;  ///< dW/dx
        Eigen::VectorXd free;      ///< K^-1 gradient, less what moves the finger
        Eigen::Vector3d finger_n = Eigen::Vector3d::Zero();
        double energy_j = 0.0;
    };
    /// One step of L-BFGS: what x and the gradient changed by.
    struct Pair {
        Eigen::VectorXd s, y;
        double per_sy;
    };

    bool evaluate(State& state) const;
    /// K^-1 g, less what moves the finger; finger_n: what the finger bears of g.
    Eigen::VectorXd projected(const Eigen::VectorXd& g, Eigen::Vector3d& finger_n) const;
    Eigen::VectorXd direction(const State& state, const std::deque<Pair>& kept) const;
    std::optional<State> line_search(const State& from, const Eigen::VectorXd& down, double slope) const;
    std::optional<State> find_rest(State state, const Eigen::Vector3d& d) const;
    bool go_to(const Eigen::Vector3d& d, int halvings);

    const Hyperelastic* body_;
    const LinearSolver* solver_;
    std::span<const std::int32_t> unknown_;
    Eigen::MatrixXd w_, x_;  ///< [3n, 3] shares; K^-1 w
    Eigen::Matrix3d stiffness_;
    State rest_;
    Eigen::Vector3d d_ = Eigen::Vector3d::Zero();
};

}  // namespace haptable
