// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/loads.hpp"

#include <algorithm>

#include "codegen/in_memory.hpp"
#include "codegen/laws.hpp"

namespace haptable {

namespace {

PatchNodes ascending(PatchNodes nodes) {
    std::sort(nodes.begin(), nodes.end());
    return nodes;
}

template <typename List, typename Key>
std::size_t place_in(const List& ascending, const Key& key) {
    return static_cast<std::size_t>(std::lower_bound(ascending.begin(), ascending.end(), key) - ascending.begin());
}

NodalForce narrow(std::int32_t node, const Eigen::Vector3d& force_n) {
    const Eigen::Vector3f force = force_n.cast<float>();
    return {node, {force.x(), force.y(), force.z()}};
}

Eigen::Vector3d force_of(const NodalForce& load) { return Eigen::Vector3f(load.force_n.data()).cast<double>(); }

/// With least energy the servo has the load from its look for the minimum; of a contact alone it must be solved for.
haptable_force_fn* solving_force(const Tables& tables) {
    Tables plain;
    plain.force = tables.force;
    plain.precision = tables.precision;
    haptable_model model{};
    set_laws(plain, model);
    return model.force;
}

}  // namespace

/// Its tables, and the model that points to them.
struct ContactLoads::Servo {
    explicit Servo(const Tables& of) : tables(build_model(of)), model(model_in_memory(of, tables)) {
        model.force = solving_force(of);
    }

    ServoModel tables;
    haptable_model model;
};

ContactLoads::~ContactLoads() = default;

ContactLoads::ContactLoads(const Tables& tables)
    : tables_(tables), servo_(std::make_unique<Servo>(tables)), moves_(tables.position.size(), false) {
    const ServoModel& servo = servo_->tables;
    for (const std::int32_t node : tables.node_id) moves_[static_cast<std::size_t>(node)] = true;
    for (std::size_t p = 0; p < servo.patch.size(); ++p) {
        PatchNodes nodes{};
        for (std::size_t c = 0; c < 3; ++c) nodes[c] = servo.node[servo.patch[p][c]];
        patch_.emplace(ascending(nodes), static_cast<std::uint16_t>(p));
    }
}

bool ContactLoads::is_patch(PatchNodes nodes) const { return patch_.contains(ascending(nodes)); }

std::vector<NodalForce> ContactLoads::of(const PatchNodes& nodes, const std::array<double, 3>& alpha,
                                         const Eigen::Vector3d& finger_m, const Eigen::Vector3d& god_object_m) const {
    const auto& [servo, model] = *servo_;
    haptable_contact contact{};
    contact.patch = patch_.at(ascending(nodes));
    std::array<std::size_t, 3> given{};  // which of `nodes` stands at the servo's corner c
    float finger[3];
    for (std::size_t c = 0; c < 3; ++c) {
        const std::int32_t at = servo.node[servo.patch[contact.patch][c]];
        given[c] = static_cast<std::size_t>(std::find(nodes.begin(), nodes.end(), at) - nodes.begin());
        contact.alpha[c] = static_cast<float>(alpha[given[c]]);
        const auto axis = static_cast<Eigen::Index>(c);
        contact.god_object_m[c] = static_cast<float>(god_object_m[axis]);
        finger[c] = static_cast<float>(finger_m[axis]);
    }
    float nodal_force_n[3][3], force_n[3];
    model.force(&model, &contact, finger, nodal_force_n, force_n);
    std::vector<NodalForce> loads(3);
    for (std::size_t c = 0; c < 3; ++c)
        loads[given[c]] = {nodes[given[c]], {nodal_force_n[c][0], nodal_force_n[c][1], nodal_force_n[c][2]}};
    return loads;
}

/// Adds what a load on a control point puts on the nodes under the mask there.
void ContactLoads::add_control(std::size_t control, double share, std::map<std::int32_t, double>& weight) const {
    const ComplianceTables& c = tables_.compliance;
    const auto end = static_cast<std::size_t>(c.spread_begin.at(control + 1));
    for (auto i = static_cast<std::size_t>(c.spread_begin.at(control)); i < end; ++i)
        weight[c.spread_node[i]] += share * static_cast<double>(c.spread_weight[i]);
}

std::vector<NodalForce> ContactLoads::spread(const std::vector<NodalForce>& on_patch) const {
    if (tables_.force != ForceLaw::kPressureMask || on_patch.size() != 3) return on_patch;
    const PatchNodes node{on_patch[0].node, on_patch[1].node, on_patch[2].node};
    Eigen::Vector3d load_n = Eigen::Vector3d::Zero();
    for (const NodalForce& force : on_patch) load_n += force_of(force);
    if (!is_patch(node) || load_n.squaredNorm() <= 0.0) return on_patch;
    std::array<double, 3> alpha{};
    for (std::size_t k = 0; k < 3; ++k) alpha[k] = force_of(on_patch[k]).dot(load_n) / load_n.squaredNorm();
    const ComplianceTables& c = tables_.compliance;
    std::map<std::int32_t, double> weight;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t a = (k + 1) % 3, b = (k + 2) % 3;
        const std::array<std::int32_t, 2> edge{std::min(node[a], node[b]), std::max(node[a], node[b])};
        add_control(place_in(c.vertex_id, node[k]), alpha[k] * alpha[k], weight);
        add_control(c.vertex_id.size() + place_in(c.edge_id, edge), 2.0 * alpha[a] * alpha[b], weight);
    }
    std::vector<NodalForce> loads;
    for (const auto& [at, w] : weight)
        if (moves_[static_cast<std::size_t>(at)]) loads.push_back(narrow(at, w * load_n));
    return loads;
}

}  // namespace haptable
