// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-strokes: random strokes over meshes, every tick judged by geometry and tables that are not the servo's.
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/json.hpp"
#include "host/base/own_folder.hpp"
#include "host/base/program.hpp"
#include "host/precompute/precompute.hpp"
#include "host/strokes/campaign.hpp"

namespace {

using namespace haptable;
namespace fs = std::filesystem;

struct Options {
    CampaignOptions campaign;
    fs::path out;
    fs::path stroke;
    bool quiet = false;
};

/// One stroke, on one scene as that says: what the judge saw, tick by tick.
void judge_one(const Options& options) {
    if (options.campaign.places.size() != 1) throw Error("--judge: give one scene to judge the stroke on");
    Progress progress(options.quiet);
    const Scene scene = read_scene(options.campaign.places.front());
    const fs::path folder = options.campaign.folder / "judged" / scene.name;
    precompute(scene, folder, progress);
    const StrokedBody body(read_scene_files(folder));
    const StrokedModel model(body, scene.contact, body.tools());
    std::string told = kJudgedColumns;
    judge(model.touched(), read_stroke(options.stroke), &told);
    progress.clear();
    fmt::print("{}", told);
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

/// "20 strokes, none broke a promise", or "20 strokes, 3 lost, 1 jump".
std::string faults_of(const Tally& tally) {
    std::string text = fmt::format("{} strokes", tally.strokes);
    for (std::size_t f = 0; f < kFaults; ++f)
        if (tally.faulty[f] > 0) text += fmt::format(", {} {}", tally.faulty[f], kFaultNames[f]);
    return tally.broken.empty() ? text + ", none broke a promise" : text;
}

void run(const Options& options) {
    OwnFolder own(options.campaign.folder, kStrokes);
    for (const char* part : {"meshes", "tables", "counts", "faults", "judged"}) own.file(part);
    if (!options.stroke.empty()) return judge_one(options);
    const auto begin = std::chrono::steady_clock::now();
    const CampaignResult result = stroke_all(options);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
    if (!options.out.empty()) write_file(options.out, json_text(to_json(result), 1) + "\n");
    if (options.quiet) return;
    for (const StrokedMeshResult& one : result.results) fmt::print("{}: {}\n", one.mesh.name, faults_of(one.total()));
    for (const LeftOut& left_out : result.left_out) fmt::print("left out: {}: {}\n", left_out.name, left_out.why);
    fmt::print("{:.1f} minutes; {} strokes were counted by earlier runs\n", elapsed.count() / 60.0, result.taken_over);
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
    app.option(
        "--mode", campaign.modes,
        "only the mode of this name, or those with it in theirs, as consistent-least-energy-friction-two-free-rings");
    app.option("--most-nodes", campaign.most_nodes, "larger meshes are left out").show_default();
    app.option("--most-mask-nodes", campaign.most_mask_nodes, "larger meshes are not touched by masks").show_default();
    app.option("--most-coupling", campaign.most_coupling,
               "bytes that couple any two places: where it is more, two fingers do not touch")
        .show_default();
    app.option("--examples", campaign.examples, "strokes of each fault, body and mode that are shrunk and written")
        .show_default();
    app.option("--build", campaign.folder, "folder for tables, counts and strokes that broke something").show_default();
    app.option("-o", options.out, "write every count to this JSON file; make strokes makes docs/STROKES.md of it");
    app.option("--judge", options.stroke, "only judge this stroke, a CSV as the servo's, on one scene in its own mode");
    app.option("--threads", campaign.threads, "default: all processors; they change no count").range(1, 1024);
    app.flag("--again", campaign.again, "count again what an earlier run has counted");
    app.flag("--quiet", options.quiet, "no table, no progress bar");
    catch_interrupts();
    return run_program(app, argc, argv, [&] { run(options); });
}
