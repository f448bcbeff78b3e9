// SPDX-License-Identifier: GPL-2.0-or-later
// The firmware's own sources compiled in double precision: what rounding does to the servo, and derivatives by
// differences.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>

#include "firmware/haptable_model.h"

namespace haptable::test {

class ReferenceServo {
public:
    /// The same tables, each float as the double that it is, and the same modes.
    explicit ReferenceServo(const haptable_model& model);
    ~ReferenceServo();
    ReferenceServo(const ReferenceServo&) = delete;
    ReferenceServo& operator=(const ReferenceServo&) = delete;

    struct Tick {
        int state;
        int patch;
        Eigen::Vector3d alpha, god, force;
    };
    Tick step(const Eigen::Vector3d& finger);
    void set_contact(int patch, const Eigen::Vector3d& alpha, const Eigen::Vector3d& last_finger);

    struct Energy {
        double energy;
        Eigen::Vector3d load;
        Eigen::Vector2d gradient;
        Eigen::Matrix2d hessian, gauss_newton;
    };
    /// At a point of a patch, which need not be the god-object. Needs a model with an energy.
    Energy energy(int patch, const Eigen::Vector3d& alpha, const Eigen::Vector3d& finger) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace haptable::test
