// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/target/fingers.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "codegen/in_memory.hpp"
#include "codegen/pair.hpp"
#include "host/base/error.hpp"
#include "host/numbers/numbers.hpp"
#include "host/precompute/precompute.hpp"
#include "host/scene/scene.hpp"
#include "host/target/image.hpp"
#include "host/target/modes.hpp"
#include "host/target/strokes.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

constexpr int kStrokes = 200;  // 4,000 ticks
constexpr const char* kTarget = "cortex-m7";

/// The cube's top under a force.
class Top {
public:
    Top(ForceLaw force, const fs::path& folder) : tables_(made(force, folder)), servo_(build_model(tables_)) {
        pair_ = build_pair(*read_pair(folder), tables_, servo_);
        model_ = model_in_memory(tables_, servo_);
    }
    Top(const Top&) = delete;
    Top& operator=(const Top&) = delete;

    const Tables& tables() const { return tables_; }
    haptable_model model(const Mode& mode) const { return in_mode(model_, mode); }
    haptable_pair_model pair(const haptable_model& model) const { return pair_in_memory(pair_, tables_, model); }

private:
    static Tables made(ForceLaw force, const fs::path& folder) {
        Scene scene = read_scene("meshes/cube.toml");
        scene.touch.push_back({std::array<double, 6>{-1, -1, 0.0299, 1, 1, 1}, "", 1});
        scene.contact.fingers = 2;
        scene.contact.force = force;
        scene.contact.mask_radius_m = force == ForceLaw::kPressureMask ? 0.012 : 0.0;
        scene.tables.columns = ColumnRows::kNone;
        Progress progress(true);
        precompute(scene, folder, progress);
        return read_tables(folder);
    }

    Tables tables_;
    ServoModel servo_;
    ServoPair pair_;
    haptable_model model_{};
};

struct Ticks {
    std::vector<std::uint64_t> sliding;
    std::uint64_t worst = 0;
};

Ticks of(const std::vector<TargetTick>& ticks, std::size_t fingers) {
    Ticks to;
    for (std::size_t i = 1; i < ticks.size(); ++i) {
        to.worst = std::max(to.worst, ticks[i].instructions);
        if (ticks[i - 1].touches(fingers) && ticks[i].touches(fingers)) to.sliding.push_back(ticks[i].instructions);
    }
    if (to.sliding.empty()) throw Error("the bench's fingers touched nothing: no instructions were counted");
    std::sort(to.sliding.begin(), to.sliding.end());
    return to;
}

std::uint64_t quantile(const Ticks& ticks, double fraction) {
    return ticks.sliding[static_cast<std::size_t>(fraction * static_cast<double>(ticks.sliding.size() - 1))];
}

void add_costs(const Mode& mode, const Top& top, const TargetImage& image, FingerCosts& to) {
    const haptable_model model = top.model(mode);
    const haptable_pair_model pair = top.pair(model);
    const Ticks one = of(image.measure({model}, hard_path(top.tables(), kStrokes)), 1);
    const Ticks two = of(image.measure({model, &pair}, hard_path_of_two(top.tables(), kStrokes)), 2);
    const std::uint64_t median = quantile(one, 0.5), medians = quantile(two, 0.5);
    const std::uint64_t bound = most_pair_cost(mode, most_patches_around_a_vertex(model));
    const double ratio = static_cast<double>(medians) / static_cast<double>(median);
    to.costs.rows.push_back({mode.name(), count(median), count(medians), number(ratio, fmt::format("{:.2f}", ratio)),
                             count(quantile(two, 0.999)), count(two.worst), count(bound),
                             parts_in_time(bound, two.worst)});
    to.rates.rows.push_back(
        {mode.name(), parts_in_time(bound, two.worst, 0.2e-3), parts_in_time(bound, two.worst, 0.1e-3)});
}

}  // namespace

std::string parts_in_time(std::uint64_t bound, std::uint64_t worst, double time_s) {
    std::string by_bound, counted;
    for (const auto& [name, clock_hz] :
         {std::pair{"M33 150 MHz", 150e6}, {"M4F 168 MHz", 168e6}, {"rv32 400 MHz", 400e6}, {"M7 600 MHz", 600e6}}) {
        const double most = time_s * clock_hz;
        std::string& list = static_cast<double>(bound) <= most ? by_bound : counted;
        if (static_cast<double>(worst) <= most) list += (list.empty() ? "" : ", ") + std::string(name);
    }
    if (!counted.empty()) counted = "counted: " + counted;
    if (by_bound.empty() && counted.empty()) return "none";
    return by_bound + (by_bound.empty() || counted.empty() ? "" : "; ") + counted;
}

FingerCosts finger_costs(const fs::path& build) {
    const TargetImage image(build, "cube", kTarget);
    if (const std::string missing = image.missing(); !missing.empty()) throw Error(missing);
    FingerCosts costs{
        {{"force, god-object", "one finger", "two in contact", "ratio", "99.9 %", "worst of all", "bound", "in 0.9 ms"},
         {}},
        {{"force, god-object", "5 kHz", "10 kHz"}, {}}};
    std::unique_ptr<Top> top;
    for (const ForceLaw force : every<ForceLaw>()) {
        top = std::make_unique<Top>(force, build / "fingers" / word(force));
        for (const Mode& mode : every_mode())
            if (mode.force == force) add_costs(mode, *top, image, costs);
    }
    return costs;
}

}  // namespace haptable
