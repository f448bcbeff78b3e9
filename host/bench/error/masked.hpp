// SPDX-License-Identifier: GPL-2.0-or-later
// A mesh of one element under fingers with a size: what their masks feel, by Poisson's ratio.
#pragma once

#include <map>
#include <span>
#include <vector>

#include "host/bench/error/footprint.hpp"
#include "host/bench/error/specimen.hpp"
#include "host/precompute/body.hpp"
#include "host/precompute/locking.hpp"

namespace haptable {

/// A finger's pad, (1 - r^2 / R^2)^2, and where it presses.
struct Finger {
    double radius_m;
    Place place;
};

std::vector<Finger> fingers_at(std::span<const Place> places, double radius_m);

/// A body of one element with the masks of fingers; Poisson's ratio comes later.
class Masked {
public:
    Masked(Scene scene, Element element, std::span<const Finger> fingers);

    struct Felt {
        std::vector<double> normal_n_per_m;  ///< n . S n under the fingers
        double cpu_s = 0.0;                  ///< of the factor and the blocks L_ii, one thread
        Locking told;                        ///< by a run of haptable-precompute, under the first finger's mask
    };
    Felt at(double poisson);
    /// What haptable-precompute --check would say of it.
    double foreseen_at(double poisson);
    std::size_t nodes() const { return body_.mesh.position_m.size(); }

private:
    Scene scene_;
    Body body_;
    std::map<double, Masks> masks_;  // by radius
    std::vector<LoadShares> load_;
    std::vector<Eigen::Vector3d> outward_;
};

/// The mean over the fingers of one over the other, less 1.
double excess(std::span<const double> felt, std::span<const double> body);

}  // namespace haptable
