// SPDX-License-Identifier: GPL-2.0-or-later
// Several points that dent one body, fingers or a tool's, beside direct solves with its compliance.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "codegen/in_memory.hpp"
#include "codegen/pair.hpp"
#include "host/session/scene_state.hpp"
#include "tests/bodies.hpp"
#include "tests/dense.hpp"
#include "tests/finger.hpp"

namespace haptable::test {

constexpr ForceLaw kCompliances[] = {ForceLaw::kConsistent, ForceLaw::kPressureMask};

/// What one hand or several hold against a body; who derives moves them.
class TouchingPoints {
public:
    TouchingPoints(const ElasticBody& body, std::size_t count, const TouchOptions& options)
        : body_(body),
          count_(count),
          tables_(body.tables(options)),
          pair_(build_pair(body.pair(), tables_, body.servo())),
          model_(model_in_memory(tables_, body.servo())) {}
    TouchingPoints(const TouchingPoints&) = delete;
    TouchingPoints& operator=(const TouchingPoints&) = delete;

    std::size_t count() const { return count_; }
    const haptable_point& point(std::size_t i) const { return haptable_points_in(state_->scene_points(), memory())[i]; }
    const haptable_servo& servo(std::size_t i) const {
        return haptable_points_servos(state_->scene_points(), memory())[i];
    }
    /// On the body, N.
    Eigen::Vector3d load(std::size_t i) const { return to_vector(point(i).load_n); }
    Eigen::Vector3d dent(std::size_t i) const {
        return to_vector(servo(i).finger_m) - to_vector(point(i).at.god_object_m) + to_vector(point(i).sunk_m);
    }
    Eigen::Vector3d normal(std::size_t i) const { return to_vector(point(i).normal); }
    std::vector<std::size_t> pressing_points() const {
        std::vector<std::size_t> in;
        for (std::size_t i = 0; i < count_; ++i)
            if (point(i).presses) in.push_back(i);
        return in;
    }
    std::size_t pressing() const { return pressing_points().size(); }
    double energy() const { return double(state_->points().energy_j); }
    const ElasticBody& body() const { return body_; }
    const haptable_model& model() const { return model_; }
    const haptable_scene& scene() const { return state_->scene(); }
    void* memory() const { return state_->memory(); }

    /// The loads of these points that dent the body so deep, by C from solves, one behind the other.
    Eigen::VectorXd direct_loads(const std::vector<std::size_t>& of) const {
        const auto n = Eigen::Index(of.size());
        Eigen::MatrixXd c(3 * n, 3 * n);
        Eigen::VectorXd u(3 * n);
        for (Eigen::Index i = 0; i < n; ++i) {
            u.segment<3>(3 * i) = dent(of[std::size_t(i)]);
            for (Eigen::Index j = 0; j < n; ++j)
                c.block<3, 3>(3 * i, 3 * j) =
                    body_.coupling(point(of[std::size_t(i)]).at, point(of[std::size_t(j)]).at);
        }
        return dense::solve(c, u);
    }
    /// How far the points that press are from their direct loads, as a part of these.
    double off_direct_loads() const {
        const std::vector<std::size_t> in = pressing_points();
        if (in.empty()) return 0.0;
        const Eigen::VectorXd wanted = direct_loads(in);
        Eigen::VectorXd off = wanted;
        for (std::size_t i = 0; i < in.size(); ++i) off.segment<3>(3 * Eigen::Index(i)) -= load(in[i]);
        return off.norm() / wanted.norm();
    }
    /// The largest tangent of a load over its part along the normal.
    double steepest() const {
        double most = 0.0;
        for (const std::size_t i : pressing_points()) {
            const double along = -load(i).dot(normal(i));
            EXPECT_GT(along, 0.0) << "it pulls";
            most = std::max(most, (load(i) + along * normal(i)).norm() / along);
        }
        return most;
    }

    std::uint32_t time_us = 0;

protected:
    const Tables& tables() const { return tables_; }
    const ServoPair& coupling() const { return pair_; }
    ServoPair& coupling() { return pair_; }
    void begin(const haptable_pair_model* pair, const haptable_tool_model* tool) {
        state_.emplace(model_, pair, nullptr, nullptr, tool);
        state_->check(HAPTABLE_CHECK_ALL);
    }
    SceneState& state() { return *state_; }

private:
    const ElasticBody& body_;
    std::size_t count_;
    Tables tables_;
    ServoPair pair_;
    haptable_model model_;
    std::optional<SceneState> state_;
};

/// Of a loop that presses in its first quarter, slides in its middle and lifts in its last: each from 0 to 1.
struct LoopPhase {
    explicit LoopPhase(double t)
        : in(std::clamp(t / 0.25, 0.0, 1.0) - std::clamp((t - 0.75) / 0.25, 0.0, 1.0)),
          slide(std::clamp((t - 0.25) / 0.5, 0.0, 1.0)),
          swing(std::sin(std::numbers::pi * slide)) {}
    double in, slide, swing;
};

}  // namespace haptable::test
