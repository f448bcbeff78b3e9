// SPDX-License-Identifier: GPL-2.0-or-later
// What a contact loads the body with: on the nodes of its patch, or on those under its mask.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "host/tables/tables.hpp"

namespace haptable {

/// A force on one mesh node.
struct NodalForce {
    std::int32_t node = -1;  ///< mesh node
    std::array<float, 3> force_n{};

    bool operator==(const NodalForce&) const = default;
};

/// The three mesh nodes of a patch.
using PatchNodes = std::array<std::int32_t, 3>;

/// The loads of one scene's contacts. `tables` must outlive it.
class ContactLoads {
public:
    explicit ContactLoads(const Tables& tables);
    ~ContactLoads();
    ContactLoads(const ContactLoads&) = delete;
    ContactLoads& operator=(const ContactLoads&) = delete;

    const Tables& tables() const { return tables_; }
    std::uint64_t tables_hash() const { return tables_.tables_hash; }  ///< that messages of their servo carry
    bool is_patch(PatchNodes nodes) const;                             ///< touchable, the nodes in any order

    /// The load that the servo itself computes (equations 9 and 10, or C^-1 u; not cut to the device's limit), in
    /// newtons, for a contact on the patch `nodes` at area coordinates alpha. Before: is_patch(nodes).
    std::vector<NodalForce> of(const PatchNodes& nodes, const std::array<double, 3>& alpha,
                               const Eigen::Vector3d& finger_m, const Eigen::Vector3d& god_object_m) const;

    /// Nodal forces on one patch as its mask spreads them over the nodes under it: w = sum alpha_v^2 B_v + sum 2
    /// alpha_v alpha_w B_vw, alpha the shares of the whole load. Without a mask, or on other than a patch: as they are.
    std::vector<NodalForce> spread(const std::vector<NodalForce>& on_patch) const;

private:
    void add_control(std::size_t control, double share, std::map<std::int32_t, double>& weight) const;

    const Tables& tables_;
    struct Servo;
    std::unique_ptr<const Servo> servo_;
    std::map<PatchNodes, std::uint16_t> patch_;  ///< the servo's, by ascending mesh nodes
    std::vector<bool> moves_;                    ///< [N] false for nodes that are held still
};

}  // namespace haptable
