// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/moving_body.hpp"

#include <algorithm>

namespace haptable::test {

namespace {

using Eigen::Vector3d;

void put(const Vector3d& from, float to[3]) {
    for (int c = 0; c < 3; ++c) to[c] = static_cast<float>(from[c]);
}

double floor_energy(const haptable_body& body, const haptable_body_state& state) {
    const Vector3d up = to_vector(body.floor_normal);
    double energy = 0.0;
    for (std::uint32_t i = 0; i < body.point_count; ++i) {
        const Vector3d at =
            position_of(state) + turn_of(state) * (to_vector(body.point_m[i]) - to_vector(body.centre_m));
        const double gap = std::min(0.0, up.dot(at) - double(body.floor_m));
        const double along = std::hypot(double(state.stretch_m[i][0]), double(state.stretch_m[i][1]));
        energy += 0.5 * double(body.floor_stiffness_n_per_m) * (gap * gap + along * along);
    }
    return energy;
}

}  // namespace

haptable_body cube_body() {
    haptable_body body{};
    body.mass_kg = static_cast<float>(kMass_kg);
    put(Vector3d::Constant(kSide_m / 2.0), body.centre_m);
    for (int c = 0; c < 3; ++c) body.inertia_kg_m2[c] = static_cast<float>(kMass_kg * kSide_m * kSide_m / 6.0);
    body.floor_normal[2] = body.floor_along[0] = 1.0F;
    return body;
}

void add_floor(haptable_body& body, double height_m, double friction) {
    body.floor_m = static_cast<float>(height_m);
    body.floor_stiffness_n_per_m = static_cast<float>(kMass_kg * 1e4);
    body.floor_damping_n_s_per_m = static_cast<float>(kMass_kg * 1e2);
    body.floor_friction = static_cast<float>(friction);
    body.point_count = 8;
    for (int i = 0; i < 8; ++i) put(kSide_m * Vector3d(i & 1, (i >> 1) & 1, (i >> 2) & 1), body.point_m[i]);
}

void add_gravity(haptable_body& body, const Vector3d& g) { put(g, body.gravity_m_per_s2); }

double energy_of(const haptable_body& body, const haptable_body_state& state) {
    const Vector3d v = to_vector(state.velocity_m_per_s), w = to_vector(state.spin_rad_per_s);
    const Vector3d out = position_of(state) - to_vector(body.centre_m);
    const float* j = body.inertia_kg_m2;
    Eigen::Matrix3d inertia;
    inertia << double(j[0]), double(j[3]), double(j[5]), double(j[3]), double(j[1]), double(j[4]), double(j[5]),
        double(j[4]), double(j[2]);
    const Vector3d q = turn_of(state).normalized().vec();
    double energy = 0.5 * double(body.mass_kg) * v.squaredNorm() + 0.5 * w.dot(inertia * w) -
                    double(body.mass_kg) * to_vector(body.gravity_m_per_s2).dot(out);
    for (int c = 0; c < 3; ++c)
        energy += 0.5 * double(body.stiffness_n_per_m[c]) * out[c] * out[c] +
                  2.0 * double(body.turn_stiffness_n_m[c]) * q[c] * q[c];
    return energy + floor_energy(body, state);
}

}  // namespace haptable::test
