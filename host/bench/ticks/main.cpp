// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-bench-ticks: what a tick of a servo takes while its finger slides, for lab/error.py and lab/contact.py.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "codegen/codegen.hpp"
#include "host/base/process_cost.hpp"
#include "host/base/program.hpp"
#include "host/bench/subject.hpp"

namespace {

using namespace haptable;
namespace fs = std::filesystem;

constexpr std::size_t kRound = 1000;            // ticks once round the circle
constexpr double kReleaseOfLeastEnergy = 0.01;  // N/ms, as a scene has by default

/// A folder's servo, and what its ticks took.
struct Timed {
    std::unique_ptr<LoadedScene> scene;
    FingerPath path;
    std::vector<double> tick_s = {};
};

/// The servo in every precision and with every god-object.
void add(const fs::path& folder, double depth_m, std::vector<Timed>& to) {
    const SceneFiles files = read_unlimited(folder);
    for (const Storage storage : every<Storage>())
        for (const GodObject god_object : every<GodObject>()) {
            SceneFiles chosen = files;
            chosen.tables.precision = storage;
            chosen.tables.god_object = god_object;
            chosen.tables.options.set("contact.release_slew",
                                      god_object == GodObject::kLeastEnergy ? kReleaseOfLeastEnergy : 0.0);
            to.push_back({std::make_unique<LoadedScene>(std::move(chosen)), circle(files.tables, depth_m, kRound)});
        }
}

void time(std::size_t ticks, Timed& timed) {
    haptable_servo servo = touched(timed.scene->model(), timed.path);
    haptable_output out{};
    const double begin = process_cost().cpu_s;
    for (std::size_t i = 0; i < ticks; ++i)
        haptable_servo_step(&timed.scene->model(), &servo, timed.path[i % kRound].data(), 0, &out);
    timed.tick_s.push_back((process_cost().cpu_s - begin) / static_cast<double>(ticks));
}

nlohmann::ordered_json to_json(const Timed& timed) {
    const Tables& tables = timed.scene->tables();
    return {{"precision", word(tables.precision)},
            {"god_object", word(tables.god_object)},
            {"bytes", flash_bytes(timed.scene->servo())},
            {"tick_s", timed.tick_s}};
}

}  // namespace

int main(int argc, char** argv) {
    CommandLine app(
        "Times a servo's ticks, in every precision and with every god-object, while a finger slides round a circle.",
        "haptable-bench-ticks");
    std::vector<fs::path> folders;
    double depth_m = 0.001;
    std::size_t ticks = 5000;
    int repetitions = 7;
    app.option("DIR", folders, "folders that haptable-precompute has made").required();
    app.option("--depth", depth_m, "m, under the surface").show_default();
    app.option("--ticks", ticks, "of a repetition").range(1, 1000000000).show_default();
    app.option("--repetitions", repetitions, "all servos in turn, so that a ratio compares the same minutes");
    return run_program(app, argc, argv, [&] {
        std::vector<Timed> timed;
        for (const fs::path& folder : folders) add(folder, depth_m, timed);
        for (int repetition = 0; repetition < repetitions; ++repetition)
            for (Timed& one : timed) time(ticks, one);
        nlohmann::ordered_json all = nlohmann::ordered_json::array();
        for (const Timed& one : timed) all.push_back(to_json(one));
        fmt::print("{}\n", all.dump());
    });
}
