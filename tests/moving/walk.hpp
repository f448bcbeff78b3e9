// SPDX-License-Identifier: GPL-2.0-or-later
// Hands that touch a body wherever it is: masses on springs to where they want to be, which is on and in its surface.
// They go after a free body, 50 ms behind it.
#pragma once

#include <random>

#include "tests/hand.hpp"
#include "tests/moving/adapter.hpp"

namespace haptable::test {

/// A body's surface, of the tables that the servo has, and places on it by lot.
class Surface {
public:
    Surface(const MovingTables& tables, std::mt19937& random) : servo_(tables.loaded().servo()), random_(random) {}

    double part() { return std::uniform_real_distribution<double>(0.0, 1.0)(random_); }
    Eigen::Vector3d any_direction();
    std::size_t any_patch() { return std::min(patches() - 1, std::size_t(part() * double(patches()))); }
    Eigen::Vector3d any_point(std::size_t patch);

    std::size_t patches() const { return servo_.patch.size(); }
    Eigen::Vector3d corner(std::size_t patch, std::size_t c) const {
        return Eigen::Vector3f(servo_.vertex_m[servo_.patch[patch][c]].data()).cast<double>();
    }
    Eigen::Vector3d at(std::size_t patch, const Eigen::Vector3d& alpha) const {
        return alpha[0] * corner(patch, 0) + alpha[1] * corner(patch, 1) + alpha[2] * corner(patch, 2);
    }
    Eigen::Vector3d middle(std::size_t patch) const { return at(patch, Eigen::Vector3d::Constant(1.0 / 3.0)); }
    Eigen::Vector3d normal(std::size_t patch) const;
    double shortest_edge_m() const;

private:
    const ServoModel& servo_;
    std::mt19937& random_;
};

class Walk {
public:
    /// Both hands begin beside the body, which may already move.
    Walk(const MovingTables& tables, MovingSession& session, const Touching& touching, std::mt19937& random);

    /// Where the hands are in the next tick, by the forces of the last.
    TwoPoints next();

private:
    void want(std::size_t hand);

    const MovingTables& tables_;
    MovingSession& session_;
    std::size_t fingers_;
    Surface surface_;
    std::array<Hand, 2> hand_;
    TwoPoints point_m_;              ///< body coordinates, of what it wants
    std::array<int, 2> left_{0, 0};  ///< ticks until it wants something else
    bool has_begun_ = false;
};

}  // namespace haptable::test
