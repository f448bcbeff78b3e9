// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/inversion/masks.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "host/base/process_cost.hpp"
#include "host/bench/cube_scene.hpp"
#include "host/inverse/pairs.hpp"
#include "host/precompute/assembly.hpp"
#include "host/precompute/point_compliance.hpp"
#include "host/solve/blas.hpp"

namespace haptable {

namespace {

constexpr double kRadius_m = 0.004;

template <typename Work>
double cost_of(const Work& work) {
    const double begin = process_cost().cpu_s;
    work();
    return process_cost().cpu_s - begin;
}

/// Operations a second of a large dense product.
double dense_rate() {
    const int n = 1000;
    const auto entries = static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
    const std::vector<double> a(entries, 1.0), b(entries, 1.0);
    std::vector<double> c(entries);
    const auto multiply = [&] { blas::gemm('N', 'N', n, n, n, 1.0, a.data(), n, b.data(), n, 0.0, c.data(), n); };
    multiply();  // takes its workspace
    return 2.0 * n * n * n / cost_of(multiply);
}

void print_row(int side) {
    const Scene scene = cube_scene(side, 0.3);
    const Body body = make_body(scene, make_mesh(scene.mesh));
    Progress quiet(true);
    Workers alone(1);
    Masks masks;
    std::vector<NodePair> pairs;
    std::vector<Eigen::Matrix3d> l_ij;
    double flops = 0.0;
    const double masks_s = cost_of([&] {
        masks = make_masks(body.mesh.position_m, body.touch_patch, kRadius_m, alone, quiet);
        pairs = mask_pairs(masks, body.unknown, alone);
    });
    const Factor factor(assemble_free(scene, body));
    const double blocks_s = cost_of([&] {
        const CompliancePairs compliance(factor.supernodes(), pairs);
        flops += compliance.flops();
        l_ij = compliance.compute(quiet, &alone);
    });
    const double products_s = cost_of([&] {
        flops += compute_mask_compliance(masks, body.mesh.position_m, body.unknown, pairs, l_ij, alone, quiet).flops;
    });
    const double all_s = masks_s + blocks_s + products_s, dense_s = flops / dense_rate();
    fmt::print("\n| {} | {} | {} | {} | {} | {:.3g} | {:.3g} | {:.3g} | {:.3g} | {:.3g} | {:.3g} | {:.2g} |",
               body.mesh.position_m.size(), masks.vertex.size() + masks.edge.size(), masks.most_nodes, pairs.size(),
               body.touch_patch.size(), flops, masks_s, blocks_s, products_s, all_s, dense_s, all_s / dense_s);
    std::fflush(stdout);
}

}  // namespace

void print_mask_costs(std::span<const int> sides) {
    fmt::print(
        "| nodes | places | nodes under one | pairs | patches | operations | masks s | blocks s | products s | all s | "
        "as one dense product s | ratio |\n|---|---|---|---|---|---|---|---|---|---|---|---|");
    for (int side : sides) print_row(side);
    fmt::print("\n\n");
}

}  // namespace haptable
