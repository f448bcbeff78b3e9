// SPDX-License-Identifier: GPL-2.0-or-later
// What couples two fingers: all pairs of controls where they fit, else clusters of the nodes that they load.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "host/body/body.hpp"
#include "host/body/mask.hpp"
#include "host/inverse/inverse.hpp"
#include "host/tables/pair.hpp"

namespace haptable {

/// How a place's controls load the nodes; p patches, n controls, m loaded nodes. The servo's order: free vertices, and
/// for a mask the fixed vertices and the edges.
struct PairControls {
    std::vector<std::int32_t> node;               ///< [m] mesh nodes, free
    std::vector<Eigen::Vector3d> node_m;          ///< [m]
    std::vector<NodeWeights> weights;             ///< [n] over places in `node`
    std::vector<std::array<std::int32_t, 6>> of;  ///< [p] its controls, -1 none: vertices, then edges opposite to them
    std::vector<std::array<double, 3>> rigid;     ///< [p] 1 where a corner is fixed
    std::vector<std::array<Eigen::Vector3d, 3>> corner_m;  ///< [p]
    bool is_mask = false;
};

/// masks: of a pressure mask; of the other forces empty.
PairControls pair_controls(const Scene& scene, const Body& body, const Masks& masks);

/// The distance below which two fingers meet: a mask's radius, or half of the mean edge.
double meeting_distance(const Scene& scene, const Body& body);

/// Bytes that computing the coupling takes: L over the loaded nodes, in double.
double pair_memory(const PairControls& controls);

/// L over the loaded nodes by solves, [3 m, 3 m], m/N.
Eigen::MatrixXd loaded_compliance(const LinearSolver& inverse, const PairControls& controls,
                                  std::span<const std::int32_t> unknown, Progress& progress);

/// All pairs where they fit into so many bytes; else the loaded nodes in clusters (cluster_pairs), and under a mask
/// what each patch loads of them. Throws Error with the least that does where not even that fits.
PairTables make_pair_tables(const PairControls& controls, const Eigen::MatrixXd& l, double meeting_m,
                            std::uintmax_t most_bytes, const ContactOptions& contact, Progress& progress);

/// How far the forces of tables are from those of L, over random pairs of places of which each is pressed along its
/// inward normal; patches without any free node have none.
struct PairError {
    std::size_t places = 0;
    double worst = 0.0;       ///< |f - f_L| / |f_L| of both forces together
    double p99 = 0.0;         ///< of 99 % of the places
    double least = 0.0;       ///< smallest eigenvalue of C between the two by the tables, over the smaller of C_cc's
    std::size_t meeting = 0;  ///< places nearer than meeting_m
};
PairError measure_pair(const PairControls& controls, const Eigen::MatrixXd& l, const PairTables& tables,
                       const ContactOptions& contact, std::size_t places);

/// C_kl of tables that have all pairs, m/N.
Eigen::Matrix3d pair_block(const PairTables& tables, std::size_t k, std::size_t l);

}  // namespace haptable
