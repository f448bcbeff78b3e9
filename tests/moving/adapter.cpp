// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/moving/adapter.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "codegen/body_modes.hpp"
#include "codegen/in_memory.hpp"
#include "codegen/pair.hpp"
#include "codegen/rigid_body.hpp"
#include "host/precompute/precompute.hpp"
#include "host/session/scene_state.hpp"
#include "tests/finger.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {

namespace {

using Eigen::Vector3d;

void put(const Vector3d& from, float to[3]) {
    for (int c = 0; c < 3; ++c) to[c] = static_cast<float>(from[c]);
}

}  // namespace

struct MovingTables::Firmware {
    TemporaryFolder folder;
    std::optional<haptable_body> body;
    std::optional<ServoPair> pair;
    ServoModes body_modes;
};

MovingTables::MovingTables(Scene scene) : scene_(std::move(scene)), firmware_(std::make_unique<Firmware>()) {
    const auto out = firmware_->folder.path() / "out";
    Progress quiet(true);
    scene_.tables.columns = ColumnRows::kNone;
    precompute(scene_, out, quiet);
    tables_ = read_tables(out);
    servo_ = build_model(tables_);
    firmware_->body = read_rigid_body(out);
    if (firmware_->body) rigid_ = rigid_of(*firmware_->body);
    if (const auto pair = read_pair(out)) firmware_->pair = build_pair(*pair, tables_, servo_);
    body_modes_ = read_modes(out);
    if (body_modes_) firmware_->body_modes = build_modes(*body_modes_, tables_, servo_);
}

MovingTables::~MovingTables() = default;

double MovingTables::stiffness_limit_n_per_m() const { return servo_.stiffness.felt_n_per_m; }
double MovingTables::size_m() const { return double(servo_.tolerance_m) * 0x1p20; }

struct MovingSession::Firmware {
    haptable_model model{};
    haptable_pair_model pair{};
    haptable_body body{};
    haptable_modes modes{};
    std::unique_ptr<SceneState> scene;
    std::uint32_t now_us = 0;

    const haptable_body_state& state() const { return *scene->body(); }
};

MovingSession::MovingSession(const MovingTables& tables, const Touching& touching)
    : tables_(tables), touching_(touching), firmware_(std::make_unique<Firmware>()) {
    Firmware& f = *firmware_;
    Tables variant = tables.tables();
    if (!touching.by_scene) {
        variant.god_object = touching.god_object;
        variant.static_friction = variant.kinetic_friction = touching.friction;
        variant.max_force_n = touching.max_force_n;
        variant.limits = {};
        variant.options.set("contact.release_slew", touching.release_n_per_ms);
    }
    f.model = model_in_memory(variant, tables.servo());
    const bool for_two = touching.fingers == 2, rings = tables.body_modes().has_value();
    if (for_two) f.pair = pair_in_memory(*tables.firmware_->pair, variant, f.model);
    if (rings) f.modes = modes_in_memory(tables.firmware_->body_modes);
    if (tables.is_free()) f.body = *tables.firmware_->body;
    if (tables.is_free() && !touching.by_scene) {
        put(touching.gravity_m_per_s2, f.body.gravity_m_per_s2);
        for (int c = 0; c < 3; ++c) {
            f.body.stiffness_n_per_m[c] = static_cast<float>(touching.hang_n_per_m);
            f.body.damping_n_s_per_m[c] = static_cast<float>(touching.hang_n_s_per_m);
            f.body.turn_stiffness_n_m[c] = static_cast<float>(touching.twist_n_m);
            f.body.turn_damping_n_m_s[c] = static_cast<float>(touching.twist_n_m_s);
        }
        f.body.floor_friction = static_cast<float>(touching.floor_friction);
        if (!touching.floor) f.body.point_count = 0;
        f.body.crc = haptable_crc_of(&f.body, haptable_span_of_body);
    }
    floor_m_ = double(f.body.floor_m);
    f.scene = std::make_unique<SceneState>(f.model, for_two ? &f.pair : nullptr, tables.is_free() ? &f.body : nullptr,
                                           rings ? &f.modes : nullptr);
    f.scene->check(HAPTABLE_CHECK_ALL);
}

MovingSession::~MovingSession() = default;

void MovingSession::step(const std::array<Vector3d, 2>& finger_m) {
    Firmware& f = *firmware_;
    haptable_input in[2] = {};
    haptable_output out[2] = {};
    for (int i = 0; i < touching_.fingers; ++i) {
        put(finger_m[std::size_t(i)], in[i].finger_m);
        in[i].is_there = 1;
    }
    f.now_us += HAPTABLE_TICK_US;
    f.scene->step(in, f.now_us, out);
    for (int i = 0; i < touching_.fingers; ++i) {
        felt_[std::size_t(i)] = felt_of(*f.scene, std::size_t(i), in[i], out[i]);
    }
}

Motion MovingSession::motion() const { return motion_of(firmware_->state(), tables_.rigid()); }

void MovingSession::put_motion(const Vector3d& velocity_m_per_s, const Vector3d& spin_rad_per_s) {
    haptable_body_state& s = *firmware_->scene->body();
    put(velocity_m_per_s, s.velocity_m_per_s);
    put(spin_rad_per_s, s.spin_rad_per_s);
    put(motion().turn * (tables_.rigid().inertia_kg_m2 * spin_rad_per_s), s.momentum_n_m_s);
}

Vector3d MovingSession::to_body(const Vector3d& world_m) const {
    if (!tables_.is_free()) return world_m;
    const Motion m = motion();
    return m.turn.conjugate() * (world_m - m.centre_m) + tables_.rigid().centre_m;
}

Vector3d MovingSession::to_world(const Vector3d& body_m) const {
    if (!tables_.is_free()) return body_m;
    const Motion m = motion();
    return m.turn * (body_m - tables_.rigid().centre_m) + m.centre_m;
}

double MovingSession::motion_j() const {
    if (!tables_.is_free()) return 0.0;
    const Motion m = motion();
    const Rigid& rigid = tables_.rigid();
    const haptable_body& body = firmware_->body;
    const Vector3d turning = m.turn.conjugate() * m.spin_momentum, out = m.centre_m - rigid.centre_m;
    double energy = 0.5 * m.momentum.squaredNorm() / rigid.mass_kg +
                    0.5 * turning.dot(rigid.inertia_kg_m2.ldlt().solve(turning)) -
                    rigid.mass_kg * to_vector(body.gravity_m_per_s2).dot(out);
    for (int c = 0; c < 3; ++c)
        energy += 0.5 * double(body.stiffness_n_per_m[c]) * out[c] * out[c] +
                  2.0 * double(body.turn_stiffness_n_m[c]) * m.turn.vec()[c] * m.turn.vec()[c];
    return energy;
}

double MovingSession::modes_j() const { return haptable::modes_j(*firmware_->scene); }

double MovingSession::contact_j() const {
    double stored = 0.0;
    for (int i = 0; i < touching_.fingers; ++i) stored += felt_[std::size_t(i)].stored_j();
    return stored;
}

void MovingSession::note(Ledger& ledger, const Motion& before) const {
    // Of what contacts on a free body hold a part is not given: what falls is given as it will be.
    const double contacts_j = tables_.is_free() ? 0.0 : contact_j();
    ledger.note(felt_.data(), std::size_t(touching_.fingers), contacts_j + modes_j(), before,
                tables_.is_free() ? motion() : Motion());
}

}  // namespace haptable::test
