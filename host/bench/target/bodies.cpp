// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/target/bodies.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "codegen/in_memory.hpp"
#include "codegen/rigid_body.hpp"
#include "host/base/error.hpp"
#include "host/bench/target/fingers.hpp"
#include "host/tables/modes.hpp"
#include "host/target/image.hpp"
#include "host/target/modes.hpp"
#include "host/target/strokes.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

/// "median / worst"; `worst` is the worst so far.
Number cell(const std::vector<TargetTick>& ticks, std::size_t fingers, std::uint64_t& worst) {
    std::vector<std::uint64_t> touching;
    std::uint64_t most = 0;
    for (std::size_t i = 1; i < ticks.size(); ++i) {
        most = std::max(most, ticks[i].instructions);
        if (ticks[i - 1].touches(fingers) && ticks[i].touches(fingers)) touching.push_back(ticks[i].instructions);
    }
    if (touching.empty()) throw Error("the bench's fingers touched no body: no instructions were counted");
    std::sort(touching.begin(), touching.end());
    worst = std::max(worst, most);
    const std::uint64_t median = touching[(touching.size() - 1) / 2];
    return {{static_cast<double>(median), static_cast<double>(most)},
            fmt::format("{} / {}", thousands(median), thousands(most))};
}

/// What the bound of a scene's tick depends on.
struct Bounded {
    Mode mode;
    std::uint64_t fan;
};

Bounded bounded(const fs::path& folder) {
    const Tables tables = read_tables(folder);
    const ServoModel servo = build_model(tables);
    return {{tables.force, tables.god_object, tables.static_friction > 0.0 ? "friction" : ""},
            most_patches_around_a_vertex(model_in_memory(tables, servo))};
}

template <std::size_t size>
std::vector<Cell> row(const std::string& what, const fs::path& build, const char* scene, std::uint64_t bound,
                      const TargetPath<size>& path_m) {
    std::vector<Cell> cells{what};
    std::uint64_t worst = 0;
    for (const char* target : kTargets)
        cells.emplace_back(cell(TargetImage(build, scene, target).replay(path_m), size / 3, worst));
    if (worst > bound) throw Error(what + ": a tick is above its bound in host/target/modes.cpp");
    cells.emplace_back(count(bound));
    cells.emplace_back(parts_in_time(bound, worst));
    return cells;
}

}  // namespace

NumberTable body_costs(const fs::path& build) {
    const Bounded one = bounded(build / "free-cube"), two = bounded(build / "grasped"),
                  rings = bounded(build / "ringing"), squeezed = bounded(build / "squeezed"),
                  wobbles = bounded(build / "wobbling");
    const std::uint64_t points = read_rigid_body(build / "free-cube")->point_count;
    const std::uint64_t modes = read_modes(build / "ringing")->modes();
    NumberTable table{{"a tick of", "Cortex-M4F", "Cortex-M7", "Cortex-M33", "rv32imafc", "bound", "in 0.9 ms"}, {}};
    table.rows.push_back(row("a cube that nothing holds", build, "free-cube",
                             most_cost(one.mode, one.fan) + most_body_cost(points, 1), tip_path()));
    table.rows.push_back(row("the same, two fingers", build, "grasped",
                             most_pair_cost(two.mode, two.fan) + most_body_cost(points, 2), grasp_path()));
    table.rows.push_back(row(fmt::format("a jelly, {} modes", modes), build, "ringing",
                             most_cost(rings.mode, rings.fan) + most_modes_cost(rings.mode, modes), knock_path()));
    table.rows.push_back(row("the same, two fingers", build, "squeezed",
                             most_pair_cost(squeezed.mode, squeezed.fan) +
                                 most_modes_pair_cost(squeezed.mode, read_modes(build / "squeezed")->modes()),
                             squeeze_path()));
    table.rows.push_back(row("the same, two fingers, that nothing holds", build, "wobbling",
                             most_pair_cost(wobbles.mode, wobbles.fan) + most_body_cost(points, 2) +
                                 most_modes_pair_cost(wobbles.mode, read_modes(build / "wobbling")->modes()),
                             grasp_path()));
    return table;
}

}  // namespace haptable
