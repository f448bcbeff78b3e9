// SPDX-License-Identifier: GPL-2.0-or-later
// A tool of many points that one hand holds: its loads, its wrench, and what it stores.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <random>
#include <vector>

#include "codegen/in_memory.hpp"
#include "codegen/pair.hpp"
#include "firmware/haptable_tool.h"
#include "tests/bodies.hpp"
#include "tests/dense.hpp"
#include "tests/finger.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

using Points = std::vector<std::array<float, 3>>;

/// How a tool's tests differ.
struct ToolOptions {
    GodObject god_object = GodObject::kNearest;
    double friction = 0.0;
    bool passivity = false;
    double max_force_n = 1e6;
    double max_torque_n_m = 1e6;
    SafetyLimits limits{};
};

/// A body, and a tool whose hand a test moves by hand.
class Tool {
public:
    Tool(const ElasticBody& body, Points points, const ToolOptions& options = {})
        : tables_(body.tables()), pair_(build_pair(body.pair(), tables_, body.servo())), points_(std::move(points)) {
        tables_.god_object = options.god_object;
        tables_.static_friction = tables_.kinetic_friction = options.friction;
        tables_.options.set("contact.release_slew", 0.0);
        tables_.options.set("contact.passivity", options.passivity);
        tables_.max_force_n = options.max_force_n;
        tables_.limits = options.limits;
        model_ = model_in_memory(tables_, body.servo());
        pair_model_ = pair_in_memory(pair_, tables_, model_);
        tool_.pair = &pair_model_;
        tool_.couple = pair_.is_exact() ? haptable_pair_couple_exact : haptable_pair_couple_clusters;
        if (model_.energy != nullptr || model_.frictionless != nullptr) tool_.settle = haptable_tool_settle;
        tool_.point_m = reinterpret_cast<const float(*)[3]>(points_.data());
        tool_.point_count = static_cast<std::uint16_t>(points_.size());
        tool_.max_torque_n_m = static_cast<float>(options.max_torque_n_m);
        for (const auto& r : points_) tool_.reach_m = std::max(tool_.reach_m, float(to_vector(r.data()).norm()));
        haptable_tool_lay_out(&tool_);
        haptable_tool_scene_make(&model_, &tool_, &scene_);
        begin();
    }
    Tool(const Tool&) = delete;
    Tool& operator=(const Tool&) = delete;

    void begin() {
        haptable_init(&scene_.scene, &room_);
        haptable_check(&scene_.scene, &room_, HAPTABLE_CHECK_ALL);
    }
    const haptable_tool_output& to(const Vector3d& p, const Quaterniond& q = Quaterniond::Identity()) {
        haptable_tool_input in{};
        for (int c = 0; c < 3; ++c) in.hand.finger_m[c] = float(p[c]);
        in.turn[0] = float(q.w());
        for (int c = 0; c < 3; ++c) in.turn[1 + c] = float(q.vec()[c]);
        in.hand.is_there = 1;
        return to(in);
    }
    const haptable_tool_output& to(const haptable_tool_input& in) {
        haptable_step(&scene_.scene, &room_, &in.hand, time_us_ += HAPTABLE_TICK_US, &out.hand);
        return out;
    }
    Vector3d force() const { return to_vector(out.hand.force_n); }
    Vector3d torque() const { return to_vector(out.torque_n_m); }
    double energy() const { return double(room_.hand.energy_j); }
    const haptable_tool_point& point(std::size_t i) const { return room_.point[i]; }
    haptable_tool_point& point(std::size_t i) { return room_.point[i]; }
    std::size_t count() const { return points_.size(); }
    std::size_t pressing() const {
        std::size_t n = 0;
        for (std::size_t i = 0; i < count(); ++i) n += point(i).presses;
        return n;
    }
    const haptable_tool_state& state() const { return room_.hand; }
    haptable_tool_room& room() { return room_; }
    const haptable_tool_model& model() const { return tool_; }
    const haptable_scene& scene() const { return scene_.scene; }
    std::uint32_t& time_us() { return time_us_; }

    haptable_tool_output out{};

private:
    Tables tables_;
    ServoPair pair_;
    Points points_;
    haptable_model model_{};
    haptable_pair_model pair_model_{};
    haptable_tool_model tool_{};
    haptable_tool_scene scene_{};
    haptable_tool_room room_{};
    std::uint32_t time_us_ = 0;
};

/// n x n points of a square, spacing apart, its middle at the handle.
Points grid(int n, double spacing_m) {
    Points points;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
            points.push_back({float((i - 0.5 * (n - 1)) * spacing_m), float((j - 0.5 * (n - 1)) * spacing_m), 0.0F});
    return points;
}

const ElasticBody& cube(ForceLaw force) {
    static const ElasticBody consistent(for_two(cube_scene(5, 0.3)), ForceLaw::kConsistent);
    static const ElasticBody mask(for_two(cube_scene(5, 0.3)), ForceLaw::kPressureMask, 0.01);
    return force == ForceLaw::kConsistent ? consistent : mask;
}

/// C between two places of the surface, by solves.
Matrix3d coupling(const ElasticBody& body, const haptable_contact& a, const haptable_contact& b) {
    const VectorXd v = body.weights(a.patch, to_vector(a.alpha)), w = body.weights(b.patch, to_vector(b.alpha));
    const MatrixXd& l = body.compliance();
    Matrix3d c = Matrix3d::Zero();
    for (Eigen::Index i = 0; i < v.size(); ++i)
        for (Eigen::Index j = 0; j < w.size(); ++j)
            if (v[i] != 0.0 && w[j] != 0.0) c += v[i] * w[j] * l.block<3, 3>(3 * i, 3 * j);
    return c;
}

TEST(Tool, LoadsAreThoseOfDirectSolvesOfAllPointsThatPress) {
    for (const ForceLaw force : {ForceLaw::kConsistent, ForceLaw::kPressureMask}) {
        const ElasticBody& body = cube(force);
        Tool tool(body, grid(3, 0.006));
        std::mt19937 random(3);
        std::uniform_real_distribution<double> any(-1.0, 1.0);
        double worst = 0.0;
        int most = 0;
        for (int trial = 0; trial < 200; ++trial) {
            tool.begin();
            const Vector3d p(0.015 + 0.003 * any(random), 0.015 + 0.003 * any(random), 0.030 - 0.0015);
            const Quaterniond q(1.0, 0.08 * any(random), 0.08 * any(random), any(random));
            tool.to(p + Vector3d(0, 0, 0.01), q.normalized());
            for (int tick = 1; tick <= 14; ++tick)
                tool.to(p + Vector3d(0, 0, 1e-3 * std::max(0, 10 - tick)), q.normalized());
            std::vector<std::size_t> in;
            for (std::size_t i = 0; i < tool.count(); ++i)
                if (tool.point(i).presses) in.push_back(i);
            if (in.empty()) continue;
            const auto n = Eigen::Index(in.size());
            MatrixXd c(3 * n, 3 * n);
            VectorXd u(3 * n), f(3 * n);
            for (Eigen::Index i = 0; i < n; ++i) {
                const haptable_tool_point& at = tool.point(in[std::size_t(i)]);
                u.segment<3>(3 * i) = to_vector(at.servo.finger_m) - to_vector(at.at.god_object_m);
                f.segment<3>(3 * i) = to_vector(at.load_n);
                for (Eigen::Index j = 0; j < n; ++j)
                    c.block<3, 3>(3 * i, 3 * j) = coupling(body, at.at, tool.point(in[std::size_t(j)]).at);
            }
            const VectorXd wanted = dense::solve(c, u);
            const double error = (f - wanted).norm() / wanted.norm();
            worst = std::max(worst, error);
            most = std::max(most, int(n));
            // A point out of T is outside of the surface as the others dent it.
            for (std::size_t i = 0; i < tool.count(); ++i) {
                const haptable_tool_point& at = tool.point(i);
                if (at.presses || !at.is_inside) continue;
                Vector3d gap = to_vector(at.servo.finger_m) - to_vector(at.at.god_object_m);
                for (Eigen::Index j = 0; j < n; ++j)
                    gap -= coupling(body, at.at, tool.point(in[std::size_t(j)]).at) * f.segment<3>(3 * j);
                if (gap.dot(to_vector(at.normal)) > -1e-6 * body.size()) continue;
                // Or where it would have to pull if it were in T.
                MatrixXd whole(3 * n + 3, 3 * n + 3);
                VectorXd dent(3 * n + 3);
                whole.topLeftCorner(3 * n, 3 * n) = c;
                dent << u, to_vector(at.servo.finger_m) - to_vector(at.at.god_object_m);
                whole.bottomRightCorner<3, 3>() = coupling(body, at.at, at.at);
                for (Eigen::Index j = 0; j < n; ++j) {
                    whole.block<3, 3>(3 * n, 3 * j) = coupling(body, at.at, tool.point(in[std::size_t(j)]).at);
                    whole.block<3, 3>(3 * j, 3 * n) = whole.block<3, 3>(3 * n, 3 * j).transpose();
                }
                const VectorXd all = dense::solve(whole, dent);
                bool pulls = false;
                for (Eigen::Index j = 0; j <= n; ++j)
                    pulls = pulls || all.segment<3>(3 * j).dot(
                                         to_vector((j == n ? at : tool.point(in[std::size_t(j)])).normal)) > 0.0;
                EXPECT_TRUE(pulls) << trial << " " << i;
            }
        }
        std::printf("worst %g most %d\n", worst, most);
        EXPECT_LT(worst, 1e-5) << force;
        EXPECT_GE(most, 6);
    }
}

/// Worst gain of closed loops of the pose, over what is stored at the most: each presses, slides and turns, and lifts.
struct Loop {
    double gained_j = 0.0, stored_j = 0.0, share = -1.0;
    std::size_t pressing = 0;
    int sets = 0;
};

/// What the hand got over a loop of poses: work of the mean of two ticks' wrenches.
template <typename Pose>
Loop go_around(Tool& tool, int ticks, const Pose& pose) {
    Loop loop;
    Vector3d p0 = Vector3d::Zero(), f0 = p0, m0 = p0;
    Quaterniond q0;
    for (int tick = 0; tick <= ticks; ++tick) {
        const auto [p, q] = pose(double(tick) / ticks);
        tool.to(p, q);
        const Vector3d f = tool.force(), m = tool.torque();
        if (tick > 0) {
            const Quaterniond by = q * q0.conjugate();
            const Vector3d turn = 2.0 * (by.w() < 0 ? -1.0 : 1.0) * by.vec();
            loop.gained_j += 0.5 * (f + f0).dot(p - p0) + 0.5 * (m + m0).dot(turn);
        }
        loop.stored_j = std::max(loop.stored_j, tool.energy());
        loop.pressing = std::max(loop.pressing, tool.pressing());
        loop.sets = std::max(loop.sets, int(tool.state().sets));
        p0 = p, q0 = q, f0 = f, m0 = m;
    }
    loop.share = loop.gained_j / loop.stored_j;
    return loop;
}

TEST(Tool, ClosedLoopsOfThePoseGainNothingWithLeastEnergy) {
    for (const GodObject god_object : {GodObject::kNearest, GodObject::kLeastEnergy})
        for (const ForceLaw force : {ForceLaw::kConsistent, ForceLaw::kPressureMask}) {
            Tool tool(cube(force), grid(3, 0.005), {.god_object = god_object});
            std::mt19937 random(3);
            std::uniform_real_distribution<double> any(-1.0, 1.0);
            Loop worst;
            for (int trial = 0; trial < 20; ++trial) {
                tool.begin();
                const double a = 0.004 * any(random), b = 0.004 * any(random), tilt = 0.2 * any(random),
                             roll = 0.2 * any(random), yaw = 0.5 * any(random), depth = 0.003;
                const auto pose = [&](double t) {
                    const auto ramp = [&](double from, double to) {
                        return std::clamp((t - from) / (to - from), 0.0, 1.0);
                    };
                    const double slide = ramp(0.25, 0.75);
                    const Vector3d p(0.015 + a * (2 * slide - 1), 0.015 + b * (2 * slide - 1),
                                     0.031 - (depth + 0.001) * (ramp(0.0, 0.25) - ramp(0.75, 1.0)));
                    const Vector3d way(tilt * std::sin(M_PI * slide), roll * std::sin(M_PI * slide), yaw * slide);
                    const double angle = way.norm();
                    return std::pair(p, Quaterniond(Eigen::AngleAxisd(angle, way / std::max(angle, 1e-12))));
                };
                const Loop loop = go_around(tool, 2000, pose);
                if (trial < 4)
                    std::printf("  loop %g of %g J: %g, %zu points, sets %d\n", loop.gained_j, loop.stored_j,
                                loop.share, loop.pressing, loop.sets);
                if (loop.share > worst.share) worst = loop;
            }
            std::printf("god %d force %d worst %g\n", int(god_object), int(force), worst.share);
            if (god_object == GodObject::kLeastEnergy) {
                EXPECT_LT(worst.share, 1e-3) << force;
            }
        }
}

}  // namespace
}  // namespace haptable::test
