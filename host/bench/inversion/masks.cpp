// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/inversion/masks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/process_cost.hpp"
#include "host/bench/cube_scene.hpp"
#include "host/precompute/precompute.hpp"
#include "host/solve/blas.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

constexpr double kRadius_m = 0.004;

/// Operations a second of a large dense product, the fastest of three.
double dense_rate() {
    const int n = 1000;
    const auto entries = static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
    const std::vector<double> a(entries, 1.0), b(entries, 1.0);
    std::vector<double> c(entries);
    double least_s = HUGE_VAL;
    for (int turn = 0; turn < 3; ++turn) {
        const double begin = process_cost().cpu_s;
        blas::gemm('N', 'N', n, n, n, 1.0, a.data(), n, b.data(), n, 0.0, c.data(), n);
        least_s = std::min(least_s, process_cost().cpu_s - begin);
    }
    return 2.0 * n * n * n / least_s;
}

double cpu_of(const Summary& summary, std::initializer_list<const char*> stages) {
    double cpu_s = 0.0;
    for (const StageCost& stage : summary.stages)
        if (std::find(stages.begin(), stages.end(), stage.name) != stages.end()) cpu_s += stage.cpu_s;
    return cpu_s;
}

Result run(const Scene& scene, const fs::path& folder) {
    Progress quiet(true);
    PrecomputeOptions options;
    options.force = true;
    options.threads = 1;
    return precompute(scene, folder, quiet, options);
}

std::vector<Cell> row(const std::string& name, Scene scene, const fs::path& build) {
    scene.tables.columns = ColumnRows::kNone;
    const Result with = run(scene, build / "with");
    scene.contact.force = ForceLaw::kInterpolated;
    scene.contact.mask_radius_m = 0.0;
    const Result without = run(scene, build / "without");
    const MaskSummary& mask = with.summary.mask;
    const double masks_s = cpu_of(with.summary, {"masks"}), blocks_s = cpu_of(with.summary, {"mask_blocks"}),
                 products_s = cpu_of(with.summary, {"mask_products"});
    // The pairs are planned with the factor's pattern; files are written and checked, as numbers and as C.
    const auto more = [&](std::initializer_list<const char*> stages) {
        return std::max(0.0, cpu_of(with.summary, stages) - cpu_of(without.summary, stages));
    };
    const double plan_s = more({"analysis"}), files_s = more({"write", "codegen"});
    const double all_s = masks_s + plan_s + blocks_s + products_s + files_s;
    const double flops = mask.blocks.flops + mask.product_flops, dense_s = flops / dense_rate();
    return {name,
            thousands(with.body.mesh.position_m.size()),
            count(mask.places),
            count(mask.most_nodes),
            count(mask.pairs),
            number(flops, fmt::format("{:.2g}", flops)),
            seconds(masks_s),
            seconds(plan_s),
            seconds(blocks_s),
            seconds(products_s),
            seconds(files_s),
            seconds(all_s),
            seconds(dense_s),
            number(all_s / dense_s, fmt::format("{:.1f}", all_s / dense_s))};
}

}  // namespace

NumberTable mask_costs(std::span<const int> sides, std::span<const fs::path> scenes, const fs::path& build) {
    NumberTable table{{"body, radius", "nodes", "places", "most nodes under one", "pairs", "operations", "masks",
                       "planned", "blocks", "products", "files, C", "all", "dense product", "ratio"},
                      {}};
    const auto add = [&](const std::string& name, const Scene& scene) {
        fmt::print(stderr, "  masks: {}{}\n", name,
                   scene.mesh.generate.empty() ? "" : fmt::format(", {} nodes a side", scene.mesh.nodes_per_side));
        table.rows.push_back(row(name, scene, build));
    };
    for (const int side : sides) {
        Scene scene = cube_scene(side, 0.3);
        scene.contact.force = ForceLaw::kPressureMask;
        scene.contact.mask_radius_m = kRadius_m;
        add(fmt::format("cube, {:g} mm", 1e3 * kRadius_m), scene);
    }
    for (const fs::path& file : scenes)
        for (const Element element : {Element::kLinear, Element::kQuadratic}) {
            Scene scene = read_scene(file);
            if (scene.contact.force != ForceLaw::kPressureMask) throw Error(file.string() + ": has no mask");
            scene.mesh.element = element;
            add(fmt::format("{}, {}, {:g} mm", scene.name, word(element), 1e3 * scene.contact.mask_radius_m), scene);
        }
    return table;
}

}  // namespace haptable
