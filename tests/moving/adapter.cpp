// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/moving/adapter.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "codegen/in_memory.hpp"
#include "tests/bodies.hpp"

namespace haptable::test {

using Eigen::Vector3d;

namespace {

Scene without_columns(Scene scene) {
    scene.tables.columns = ColumnRows::kNone;
    return scene;
}

}  // namespace

MovingTables::MovingTables(Scene scene)
    : scene_(without_columns(std::move(scene))),
      loaded_(files_of(scene_)),
      rigid_(is_free() ? rigid_of(*loaded_.body()) : Rigid()) {}

MovingSession::MovingSession(const MovingTables& tables, const Touching& touching)
    : tables_(tables), touching_(touching) {
    const LoadedScene& loaded = tables.loaded();
    Tables variant = loaded.tables();
    if (tables.is_free()) body_ = *loaded.body();
    if (!touching.by_scene) {
        variant.god_object = touching.god_object;
        variant.static_friction = variant.kinetic_friction = touching.friction;
        variant.max_force_n = touching.max_force_n;
        variant.limits = {};
        variant.options.set("contact.release_slew", touching.release_n_per_ms);
        std::copy_n(touching.gravity_m_per_s2.data(), 3, body_.gravity_m_per_s2);
        std::fill_n(body_.stiffness_n_per_m, 3, float(touching.hang_n_per_m));
        std::fill_n(body_.damping_n_s_per_m, 3, float(touching.hang_n_s_per_m));
        std::fill_n(body_.turn_stiffness_n_m, 3, float(touching.twist_n_m));
        std::fill_n(body_.turn_damping_n_m_s, 3, float(touching.twist_n_m_s));
        body_.floor_friction = float(touching.floor_friction);
        if (!touching.floor) body_.point_count = 0;
        body_.crc = haptable_crc_of(&body_, haptable_span_of_body);
    }
    model_ = model_in_memory(variant, loaded.servo());
    if (touching.fingers == 2) pair_ = pair_in_memory(*loaded.servo_pair(), variant, model_);
    scene_.emplace(model_, touching.fingers == 2 ? &pair_ : nullptr, tables.is_free() ? &body_ : nullptr,
                   loaded.modes());
    scene_->check(HAPTABLE_CHECK_ALL);
}

void MovingSession::step(const TwoPoints& finger_m) {
    haptable_input in[2] = {};
    out_ = {};
    const auto fingers = std::size_t(touching_.fingers);
    for (std::size_t f = 0; f < fingers; ++f) {
        std::copy_n(finger_m[f].data(), 3, in[f].finger_m);
        in[f].is_there = 1;
    }
    scene_->step(in, now_us_ += HAPTABLE_TICK_US, out_.data());
    for (std::size_t f = 0; f < fingers; ++f) felt_[f] = felt_of(*scene_, f, in[f], out_[f]);
}

void MovingSession::step(const TwoPoints& finger_m, Ledger& ledger) {
    const Motion before = motion();
    step(finger_m);
    // Of what contacts on a free body hold a part is not given: what falls is given as it will be.
    double contacts_j = 0.0;
    for (const Felt& felt : felt_)
        if (!tables_.is_free() && felt.touches) contacts_j += 0.5 * felt.load_n.dot(felt.inside_m - felt.god_m);
    ledger.note(felt_.data(), std::size_t(touching_.fingers), contacts_j + modes_j(*scene_), before, motion());
}

bool MovingSession::is_sound(int finger) const {
    return out(finger).state != HAPTABLE_REJECTED && out(finger).state != HAPTABLE_FAULTED &&
           felt(finger).force_n.allFinite() && felt(finger).load_n.allFinite();
}

bool MovingSession::is_sound() const {
    const Motion m = motion();
    return is_sound(0) && (touching_.fingers == 1 || is_sound(1)) && m.centre_m.allFinite() &&
           m.turn.coeffs().allFinite() && m.momentum.allFinite() && m.spin_momentum.allFinite() &&
           std::isfinite(modes_j(*scene_));
}

void MovingSession::put_motion(const Vector3d& velocity_m_per_s, const Vector3d& spin_rad_per_s) {
    haptable_body_state& s = *scene_->body();
    const Vector3d momentum = motion().turn * (tables_.rigid().inertia_kg_m2 * spin_rad_per_s);
    std::copy_n(velocity_m_per_s.data(), 3, s.velocity_m_per_s);
    std::copy_n(spin_rad_per_s.data(), 3, s.spin_rad_per_s);
    std::copy_n(momentum.data(), 3, s.momentum_n_m_s);
}

Vector3d MovingSession::to_body(const Vector3d& world_m) const {
    const Motion m = motion();
    return m.turn.conjugate() * (world_m - m.centre_m) + tables_.rigid().centre_m;
}

Vector3d MovingSession::to_world(const Vector3d& body_m) const {
    const Motion m = motion();
    return m.turn * (body_m - tables_.rigid().centre_m) + m.centre_m;
}

double MovingSession::motion_j() const {
    const Motion m = motion();
    const Rigid& rigid = tables_.rigid();
    const Vector3d turning = m.turn.conjugate() * m.spin_momentum, out = m.centre_m - rigid.centre_m;
    double energy = 0.5 * m.momentum.squaredNorm() / rigid.mass_kg +
                    0.5 * turning.dot(rigid.inertia_kg_m2.ldlt().solve(turning)) -
                    rigid.mass_kg * to_vector(body_.gravity_m_per_s2).dot(out);
    for (int c = 0; c < 3; ++c)
        energy += 0.5 * double(body_.stiffness_n_per_m[c]) * out[c] * out[c] +
                  2.0 * double(body_.turn_stiffness_n_m[c]) * m.turn.vec()[c] * m.turn.vec()[c];
    return energy;
}

void Round::add(const MovingSession& session) {
    way_m_ = step_n_ = 0.0;
    for (int f = 0; f < 2; ++f) {
        const Felt& now = session.felt(f);
        Felt& last = last_[std::size_t(f)];
        if (has_begun_) {
            const Vector3d way = now.at_m - last.at_m;
            given_j_ += 0.5 * (now.force_n + last.force_n).dot(way);
            way_m_ += way.norm();
            step_n_ = std::max(step_n_, (now.force_n - last.force_n).norm());
        }
        last = now;
    }
    has_begun_ = true;
    paid_j_ = std::max(paid_j_, -given_j_);
    most_step_n_ = std::max(most_step_n_, step_n_);
}

}  // namespace haptable::test
