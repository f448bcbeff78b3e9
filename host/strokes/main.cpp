// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-strokes: random strokes over meshes, every tick judged by geometry and tables that are not the servo's.
#include <fmt/format.h>

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

/// One stroke, on one scene as that says: what the judge saw, tick by tick.
void judge_one(const CampaignOptions& options, const fs::path& stroke) {
    if (options.places.size() != 1) throw BadCommandLine("--judge: give one scene to judge the stroke on");
    Progress progress(options.quiet);
    const Scene scene = read_scene(options.places.front());
    const fs::path folder = options.folder / "judged" / scene.name;
    precompute(scene, folder, progress);
    const StrokedBody body(read_scene_files(folder));
    const ToolTables* tool = body.loaded.tool_tables();
    const StrokedModel model(body, scene.contact, tool != nullptr ? std::vector{*tool} : std::vector<ToolTables>{});
    std::string told = kJudgedColumns;
    judge(model.touched(), read_stroke(stroke), &told);
    progress.clear();
    fmt::print("{}", told);
}

/// "20 strokes, none broke a promise", or "20 strokes, 3 lost, 1 jump".
std::string faults_of(const nlohmann::ordered_json& tally) {
    std::string text = fmt::format("{} strokes", tally.at("strokes").get<std::size_t>());
    for (const auto& [fault, strokes] : tally.at("faults").items())
        if (strokes > 0) text += fmt::format(", {} {}", strokes.get<std::size_t>(), fault);
    return tally.at("broken").empty() ? text + ", none broke a promise" : text;
}

void run(const CampaignOptions& options, const fs::path& out, const fs::path& stroke) {
    OwnFolder own(options.folder, kStrokes);
    for (const char* part : {"meshes", "tables", "counts", "faults", "judged"}) own.file(part);
    if (!stroke.empty()) return judge_one(options, stroke);
    const nlohmann::ordered_json counts = run_campaign(options);
    if (!out.empty()) write_file(out, json_text(counts, 1) + "\n");
    if (options.quiet) return;
    for (const auto& one : counts.at("left_out"))
        fmt::print("left out: {}: {}\n", one.at("name").get<std::string>(), one.at("why").get<std::string>());
    fmt::print("{}; {} were counted by earlier runs\n", faults_of(counts.at("total")),
               counts.at("taken_over_strokes").get<std::size_t>());
}

}  // namespace

int main(int argc, char** argv) {
    CommandLine app(
        "Strokes bodies at random in every mode of contact, and judges every tick. What is counted is kept: a run that "
        "was cut short goes on when it is started again.",
        "haptable-strokes");
    CampaignOptions options;
    fs::path out, stroke;
    app.option("PLACES", options.places, "scenes, meshes, or folders of them").required();
    app.option("--strokes", options.strokes, "in all").positive().show_default();
    app.option("--seed", options.seed, "of the strokes").show_default();
    app.option("--mesh", options.meshes, "only bodies with this in their name; may be given again");
    app.option(
        "--mode", options.modes,
        "only the mode of this name, or those with it in theirs, as consistent-least-energy-friction-two-free-rings");
    app.option("--most-nodes", options.most_nodes, "larger meshes are left out").show_default();
    app.option("--most-mask-nodes", options.most_mask_nodes, "larger meshes are not touched by masks").show_default();
    app.option("--most-coupling", options.most_coupling,
               "bytes that couple any two places: where it is more, two fingers do not touch")
        .show_default();
    app.option("--build", options.folder, "folder for tables, counts and strokes that broke something").show_default();
    app.option("-o", out, "write every count to this JSON file; make strokes makes docs/STROKES.md of it");
    app.option("--judge", stroke, "only judge this stroke, a CSV as the servo's, on one scene in its own mode");
    app.option("--threads", options.threads, "default: all processors; they change no count").range(1, 1024);
    app.flag("--quiet", options.quiet, "no table, no progress bar");
    catch_interrupts();
    return run_program(app, argc, argv, [&] { run(options, out, stroke); });
}
