// SPDX-License-Identifier: GPL-2.0-or-later
// Ways of a finger, what its hand is given on them, and bodies that are springs, with laws.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "codegen/laws.hpp"
#include "codegen/model.hpp"
#include "firmware/haptable_scene.h"
#include "tests/bodies.hpp"
#include "tests/finger.hpp"
#include "tests/shapes.hpp"

namespace haptable::test {

/// What a hand is given on its way, less what it gave, by the mean of a motion's forces.
struct Work {
    double given_j = 0.0, most_j = 0.0;
    double put_in_j = 0.0;  ///< the most that the hand had given

    void add(const Eigen::Vector3d& at_m, const Eigen::Vector3d& force_n) {
        if (is_under_way_) given_j += 0.5 * (force_n + force_n_).dot(at_m - at_m_);
        if (!(given_j <= most_j)) most_j = given_j;  // so that what is no number stays
        if (!(-given_j <= put_in_j)) put_in_j = -given_j;
        at_m_ = at_m;
        force_n_ = force_n;
        is_under_way_ = true;
    }

private:
    Eigen::Vector3d at_m_ = Eigen::Vector3d::Zero(), force_n_ = Eigen::Vector3d::Zero();
    bool is_under_way_ = false;
};

/// Straight from corner to corner, in so many ticks each.
template <typename To>
void walk(const std::vector<Eigen::Vector3d>& corner, int ticks, To to) {
    to(corner.front());
    for (std::size_t k = 1; k < corner.size(); ++k)
        for (int tick = 1; tick <= ticks; ++tick)
            to(Eigen::Vector3d(corner[k - 1] + (corner[k] - corner[k - 1]) * tick / ticks));
}

inline Work walk(Finger& finger, const std::vector<Eigen::Vector3d>& corner, int ticks) {
    Work work;
    walk(corner, ticks, [&](const Eigen::Vector3d& x) {
        finger.to(x);
        work.add(finger.at(), finger.force());
    });
    return work;
}

/// To points of a box by lot, straight, `step_m` a tick; from its highest corner.
class Wander {
public:
    Wander(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double step_m, unsigned seed)
        : low_(low), high_(high), step_m_(step_m), random_(seed), x_(high), aim_(high) {}
    /// Around a body, and through it.
    Wander(const TestModel& model, double step_m, unsigned seed)
        : Wander(Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), step_m, seed) {
        low_.setConstant(HUGE_VAL);
        high_ = -low_;
        for (const auto& vertex : model.servo().vertex_m) {
            low_ = low_.cwiseMin(to_vector(vertex.data()));
            high_ = high_.cwiseMax(to_vector(vertex.data()));
        }
        const Eigen::Vector3d margin = Eigen::Vector3d::Constant(0.25 * (high_ - low_).maxCoeff());
        low_ -= margin;
        x_ = aim_ = high_ += margin;
    }
    Eigen::Vector3d next() {
        if ((aim_ - x_).norm() < step_m_)
            for (int c = 0; c < 3; ++c) aim_[c] = std::uniform_real_distribution<double>(low_[c], high_[c])(random_);
        return x_ += step_m_ * (aim_ - x_).normalized();
    }

private:
    Eigen::Vector3d low_, high_;
    double step_m_;
    std::mt19937 random_;
    Eigen::Vector3d x_, aim_;
};

/// A cube of 30 mm whose every point is a spring.
class SpringBox {
public:
    static constexpr double kSpring = 500.0;  ///< N/m
    const haptable_model& model() const { return model_; }

private:
    TestModel body_{box_shape(2, Eigen::Vector3d(0.03, 0.03, 0.03))};
    std::vector<std::array<float, 6>> blocks_ =
        std::vector<std::array<float, 6>>(body_.servo().free_count, {500.0F, 500.0F, 500.0F, 0.0F, 0.0F, 0.0F});
    haptable_model model_ = [this] {
        haptable_model model = *body_.get();
        model.stiffness_n_per_m = reinterpret_cast<const float(*)[6]>(blocks_.data());
        model.stiffness_limit_n_per_m = static_cast<float>(kSpring);
        return model;
    }();
};

/// A body with the laws that these tables name, as codegen sets them, their curve and their terms.
class WithLaws {
public:
    explicit WithLaws(const haptable_model& body, const Tables& laws = {})
        : curve_(laws.stiffening.energy_j > 0.0 ? stiffening_table(laws.stiffening) : std::vector<float>()),
          model_(body) {
        set_laws(laws, model_);
        for (const RelaxationTerm& term : laws.relaxation) {
            const TickRelaxation tick = relaxation_of_tick(term);
            terms_.push_back({float(term.share), float(tick.fall), float(tick.rise)});
        }
        model_.stiffening = curve_.data();
        model_.term = reinterpret_cast<const float(*)[3]>(terms_.data());
        model_.term_count = static_cast<std::uint8_t>(terms_.size());
        model_.relaxation_reach_m = 0.005F;
        haptable_lay_out(&model_);
    }
    WithLaws(const WithLaws&) = delete;
    WithLaws& operator=(const WithLaws&) = delete;
    haptable_model& model() { return model_; }

private:
    std::vector<float> curve_;
    std::vector<std::array<float, 3>> terms_;
    haptable_model model_;
};

/// The finger over the middle of a cube of springs that relaxes, or whose dents stiffen.
class Press {
public:
    explicit Press(const Tables& laws) : curve_(laws.stiffening), body_(springs(), laws) { begin(); }
    void begin() {
        finger_.begin();
        to(-1e-6);
    }
    /// One tick; the force outwards, N.
    double to(double depth_m, double aside_m = 0.0, std::uint32_t after_us = HAPTABLE_TICK_US) {
        return double(finger_.to({0.0145 + aside_m, 0.0151, kTop_m - depth_m}, after_us).force_n[2]);
    }
    void hold(double depth_m, int ticks, double aside_m = 0.0) {
        for (int tick = 0; tick < ticks; ++tick) to(depth_m, aside_m);
    }
    void grab() { haptable_servo_buttons(&finger_.servo(), HAPTABLE_BUTTON_GRAB); }
    /// As the servo saw it.
    double depth_m() const { return double(static_cast<float>(kTop_m)) - finger_.at().z(); }
    /// What the springs give without a memory, N.
    double elastic_n() const {
        const double linear_n = SpringBox::kSpring * depth_m();
        return curve_.factor(0.5 * linear_n * depth_m()) * linear_n;
    }
    Eigen::Vector3d force() const { return finger_.force(); }
    const Finger& finger() const { return finger_; }
    const haptable_model& model() { return body_.model(); }

private:
    haptable_model springs() const {
        haptable_model model = box_.model();
        model.stiffness_limit_n_per_m *= static_cast<float>(curve_.largest_tangent(1.0));
        model.max_force_n = 1e3F;
        return model;
    }

    SpringBox box_;
    StiffeningCurve curve_;
    WithLaws body_;
    Finger finger_{body_.model()};
};

}  // namespace haptable::test
