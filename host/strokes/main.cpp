// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-strokes: random strokes over meshes, every tick judged by geometry and tables that are not the servo's.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "codegen/loaded_scene.hpp"
#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/json.hpp"
#include "host/base/own_folder.hpp"
#include "host/base/program.hpp"
#include "host/numbers/numbers.hpp"
#include "host/strokes/pair.hpp"
#include "host/strokes/report.hpp"

namespace {

using namespace haptable;
namespace fs = std::filesystem;

struct Options {
    CampaignOptions campaign;
    fs::path json, numbers;
    fs::path stroke;
    int fingers = 1;
    double mask_radius_m = 0.01;
    bool quiet = false;
};

/// One stroke, on one scene as that says: what the judge saw, tick by tick.
void judge_one(const Options& options) {
    if (options.campaign.places.size() != 1) throw Error("--judge: give one scene to judge the stroke on");
    Progress progress(options.quiet);
    const Scene scene = read_stroked_scene(options.campaign.places.front());
    const StrokedBody body(scene, options.campaign.folder / "judged" / scene.name, progress);
    const haptable_model model = body.model(scene.contact);
    const Stroke stroke = read_stroke(options.stroke);
    std::vector<Judged> ticks;
    judge(body.touched(model), stroke, &ticks);
    progress.clear();
    fmt::print("{}", to_csv(stroke, ticks));
}

/// One scene in one mode, with all pairs of places where they fit, stroked by two fingers.
PairTally stroke_by_two(const Scene& given, const TouchMode& mode, std::size_t count, const Options& options,
                        Workers& workers, Progress& progress) {
    Scene scene = in_mode(given, mode);
    scene.contact.fingers = 2;
    scene.tables.columns = ColumnRows::kNone;
    const fs::path folder = options.campaign.folder / "pairs" / (scene.name + "-" + word(mode.force));
    const StrokedBody body(scene, folder, progress);
    const haptable_model model = body.model(scene.contact);
    SceneFiles files = read_scene_files(folder);
    files.tables.god_object = mode.god_object;
    const ServoPair servo = build_pair(files.pair.value(), files.tables, body.servo());
    const haptable_pair_model pair = pair_in_memory(servo, files.tables, model);
    const Touched touched = body.touched(model);
    return run_pairs(
        {touched, pair}, StrokeMaker(body.servo()), options.campaign.seed, count, workers, [&](std::size_t done) {
            progress.done(static_cast<double>(done) / static_cast<double>(count), scene.name + ", " + mode.name());
        });
}

nlohmann::ordered_json to_json(const PairTally& tally) {
    return {{"strokes", tally.strokes},
            {"ticks", tally.ticks},
            {"contact_ticks", tally.contact_ticks},
            {"both_ticks", tally.both_ticks},
            {"left_ticks", tally.left_ticks},
            {"outside", tally.outside},
            {"lost", tally.lost},
            {"force", tally.force},
            {"broken", tally.broken}};
}

/// Two fingers on every scene in every mode, as often each.
void stroke_by_two(const Options& options) {
    std::vector<TouchMode> modes;
    for (const TouchMode& mode : all_modes()) {
        const auto is_named = [&](const std::string& part) { return mode.name().find(part) != std::string::npos; };
        const std::vector<std::string>& wanted = options.campaign.modes;
        if (wanted.empty() || std::any_of(wanted.begin(), wanted.end(), is_named)) modes.push_back(mode);
    }
    if (modes.empty()) throw Error("--mode: no mode has that in its name");
    Progress progress(options.quiet);
    Workers workers(std::max(1, options.campaign.threads));
    nlohmann::ordered_json json;
    PairTally all;
    const std::size_t each =
        std::max<std::size_t>(1, options.campaign.strokes / (modes.size() * options.campaign.places.size()));
    for (const fs::path& place : options.campaign.places)
        for (const TouchMode& mode : modes) {
            Scene scene = read_stroked_scene(place);
            if (mode.force == ForceLaw::kPressureMask && scene.contact.mask_radius_m == 0.0)
                scene.contact.mask_radius_m = options.mask_radius_m;
            const PairTally tally = stroke_by_two(scene, mode, each, options, workers, progress);
            json[scene.name][mode.name()] = to_json(tally);
            all.add(tally);
            progress.clear();
            if (!options.quiet)
                fmt::print(
                    "{:<12} {:<40} {:>9} pairs {:>11} ticks, both in contact in {:.0f} %, {} outside, {} lost, {} "
                    "no force\n",
                    scene.name, mode.name(), tally.strokes, tally.ticks,
                    100.0 * static_cast<double>(tally.both_ticks) / static_cast<double>(tally.ticks), tally.outside,
                    tally.lost, tally.force);
        }
    json["all"] = to_json(all);
    if (!options.json.empty()) write_file(options.json, json_text(json, 2) + "\n");
    if (!options.quiet)
        fmt::print("{} pairs of strokes: {} outside, {} lost, {} no force\n", all.strokes, all.outside, all.lost,
                   all.force);
}

/// Ctrl-C: says what is kept.
CampaignResult stroke_all(const Options& options) try {
    Progress progress(options.quiet);
    return run_campaign(options.campaign, progress, [&](const std::string& line) {
        if (options.quiet) return;
        progress.clear();
        fmt::print("{}\n", line);
    });
} catch (const Interrupted&) {
    fmt::print(stderr, "haptable-strokes: what is counted is kept in {}: start again to go on from there\n",
               (options.campaign.folder / "counts").string());
    throw;
}

void run(const Options& options) {
    OwnFolder own(options.campaign.folder, kStrokes);
    for (const char* part : {"meshes", "tables", "counts", "faults", "judged", "pairs"}) own.file(part);
    if (!options.stroke.empty()) return judge_one(options);
    if (options.fingers == 2) return stroke_by_two(options);
    const auto begin = std::chrono::steady_clock::now();
    const CampaignResult result = stroke_all(options);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
    const Numbers numbers = numbers_of(result);
    if (!options.json.empty()) write_file(options.json, json_text(to_json(result), 2) + "\n");
    if (!options.numbers.empty()) numbers.write(options.numbers);
    if (options.quiet) return;
    print_topics(numbers);
    fmt::print("{:.1f} minutes; {} strokes were counted by earlier runs\n", elapsed.count() / 60.0,
               thousands(result.taken_over));
}

}  // namespace

int main(int argc, char** argv) {
    CommandLine app(
        "Strokes bodies at random in every mode of contact, and judges every tick. What is counted is kept: a run that "
        "was cut short goes on when it is started again.",
        "haptable-strokes");
    Options options;
    CampaignOptions& campaign = options.campaign;
    app.option("PLACES", campaign.places, "scenes, meshes, or folders of them").required();
    app.option("--strokes", campaign.strokes, "in all").positive().show_default();
    app.option("--seed", campaign.seed, "of the strokes").show_default();
    app.option("--mesh", campaign.meshes, "only bodies with this in their name; may be given again");
    app.option("--mode", campaign.modes, "only modes with this in their name, as consistent-least-energy-friction");
    app.option("--most-nodes", campaign.most_nodes, "larger meshes are left out").show_default();
    app.option("--most-mask-nodes", campaign.most_mask_nodes, "larger meshes are not touched by masks").show_default();
    app.option("--examples", campaign.examples, "strokes of each fault, body and mode that are shrunk and written")
        .show_default();
    app.option("--build", campaign.folder, "folder for tables, counts and strokes that broke something").show_default();
    app.option("-o", options.numbers, "write the numbers for the pages to this JSON file");
    app.option("--judge", options.stroke, "only judge this stroke, a CSV as the servo's, on one scene in its own mode");
    app.option("--fingers", options.fingers, "2: pairs of strokes at once, PLACES being scenes; none may be lost")
        .range(1, 2)
        .show_default();
    app.option("--mask-radius", options.mask_radius_m, "m, with --fingers 2: of scenes that have none")
        .positive()
        .show_default();
    app.option("--json", options.json, "every count as JSON");
    app.option("--threads", campaign.threads, "default: all processors; they change no count").range(1, 1024);
    app.flag("--again", campaign.again, "count again what an earlier run has counted");
    app.flag("--quiet", options.quiet, "no table, no progress bar");
    catch_interrupts();
    return run_program(app, argc, argv, [&] { run(options); });
}
