// SPDX-License-Identifier: GPL-2.0-or-later
// Hands that touch a body wherever it is: masses on springs to where they want to be, which is on and in its surface.
// They go after a free body, 50 ms behind it.
#pragma once

#include <random>

#include "tests/hand.hpp"
#include "tests/moving/adapter.hpp"

namespace haptable::test {

class Walk {
public:
    /// Both hands begin beside the body, which may already move.
    Walk(const MovingTables& tables, MovingSession& session, const Touching& touching, std::mt19937& random);

    /// Where the hands are in the next tick, by the forces of the last.
    std::array<Eigen::Vector3d, 2> next();
    /// J, of both hands and the springs to what they want.
    double hands_j() const;
    /// J, that wanting something else gave so far.
    double wanted_j() const { return wanted_j_; }

private:
    void want(int hand);
    void wish(int hand, const Eigen::Vector3d& world_m);
    Eigen::Vector3d point_of(std::size_t patch, double above_m) const;
    double part() { return std::uniform_real_distribution<double>(0.0, 1.0)(random_); }

    const MovingTables& tables_;
    MovingSession& session_;
    Touching touching_;
    std::mt19937& random_;
    std::array<Hand, 2> hand_;
    std::array<Eigen::Vector3d, 2> point_m_;  ///< body coordinates, of what it wants
    std::array<int, 2> left_{0, 0};           ///< ticks until it wants something else
    double wanted_j_ = 0.0;
    bool has_begun_ = false;
};

}  // namespace haptable::test
