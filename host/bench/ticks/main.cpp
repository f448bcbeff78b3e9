// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-bench-ticks: what a tick of a servo takes while its finger slides, for lab/error.py and lab/contact.py.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

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
    std::unique_ptr<Subject> subject;
    FingerPath path;
    std::vector<double> tick_s = {};
};

/// The servo as its scene has it, or in every precision and with every god-object.
void add(const fs::path& folder, bool every_one, double depth_m, std::vector<Timed>& to) {
    const auto put = [&](Tables tables) {
        auto subject = std::make_unique<Subject>(folder, std::move(tables));
        to.push_back({std::move(subject), {}});
        to.back().path = to.back().subject->circle(depth_m, kRound);
    };
    if (!every_one) return put(read_tables(folder));
    for (const Storage storage : every<Storage>())
        for (const GodObject god_object : every<GodObject>()) {
            Tables tables = read_tables(folder);
            tables.precision = storage;
            tables.god_object = god_object;
            tables.options.set("contact.release_slew",
                               god_object == GodObject::kLeastEnergy ? kReleaseOfLeastEnergy : 0.0);
            put(std::move(tables));
        }
}

void time(std::size_t ticks, Timed& timed) {
    haptable_servo servo = timed.subject->touched(timed.path);
    haptable_output out{};
    const double begin = process_cost().cpu_s;
    for (std::size_t i = 0; i < ticks; ++i)
        haptable_servo_step(&timed.subject->model(), &servo, timed.path[i % kRound].data(), 0, &out);
    timed.tick_s.push_back((process_cost().cpu_s - begin) / static_cast<double>(ticks));
}

nlohmann::ordered_json to_json(const Timed& timed) {
    const Tables& tables = timed.subject->tables();
    return {{"precision", word(tables.precision)},
            {"god_object", word(tables.god_object)},
            {"bytes", timed.subject->table_bytes()},
            {"tick_s", timed.tick_s}};
}

}  // namespace

int main(int argc, char** argv) {
    CommandLine app("Times the ticks of servos while a finger slides round a circle.", "haptable-bench-ticks");
    std::vector<fs::path> folders;
    double depth_m = 0.001;
    std::size_t ticks = 5000;
    int repetitions = 7;
    bool every_one = false;
    app.option("DIR", folders, "folders that haptable-precompute has made").required();
    app.option("--depth", depth_m, "m, under the surface").show_default();
    app.option("--ticks", ticks, "of a repetition").range(1, 1000000000).show_default();
    app.option("--repetitions", repetitions, "all servos in turn, so that a ratio compares the same minutes");
    app.flag("--every", every_one, "in every precision and with every god-object");
    return run_program(app, argc, argv, [&] {
        std::vector<Timed> timed;
        for (const fs::path& folder : folders) add(folder, every_one, depth_m, timed);
        for (int repetition = 0; repetition < repetitions; ++repetition)
            for (Timed& one : timed) time(ticks, one);
        nlohmann::ordered_json all = nlohmann::ordered_json::array();
        for (const Timed& one : timed) all.push_back(to_json(one));
        fmt::print("{}\n", all.dump());
    });
}
