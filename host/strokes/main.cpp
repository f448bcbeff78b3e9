// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-strokes: random strokes over meshes, every tick judged by geometry and tables that are not the servo's.
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <ctime>
#include <nlohmann/json.hpp>
#include <thread>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/program.hpp"
#include "host/report/page.hpp"
#include "host/strokes/report.hpp"
#include "host/strokes/shrink.hpp"

namespace {

using namespace haptable;
namespace fs = std::filesystem;

struct Options {
    std::vector<fs::path> places;
    std::vector<std::string> meshes, modes;
    std::size_t strokes = 1'000'000;
    std::uint64_t seed = 1;
    std::size_t most_nodes = 150'000;
    std::size_t examples = 3;
    fs::path folder = "build/strokes";
    fs::path json, numbers;
    fs::path stroke;
    int threads = 0;
    bool quiet = false;
};

std::vector<TouchMode> wanted_modes(const Options& options) {
    std::vector<TouchMode> modes;
    for (const TouchMode& mode : all_modes()) {
        const auto fits = [&](const std::string& part) { return mode.name().find(part) != std::string::npos; };
        if (options.modes.empty() || std::any_of(options.modes.begin(), options.modes.end(), fits))
            modes.push_back(mode);
    }
    if (modes.empty())
        throw Error(
            "--mode: no mode has that in its name; they are interpolated-nearest, "
            "consistent-least-energy-friction and so on");
    return modes;
}

/// Each mode of each body has strokes of its own.
std::uint64_t seed_of(const Options& options, const std::string& body, const TouchMode& mode) {
    std::uint64_t hash = options.seed * 0x100000001b3U;
    for (char c : body + "/" + mode.name()) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;  // FNV-1a
    return hash;
}

/// The strokes of a campaign, one body after the other.
class Campaign {
public:
    explicit Campaign(const Options& options)
        : options_(options),
          progress_(options.quiet),
          workers_(options.threads > 0 ? options.threads
                                       : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()))) {}

    CampaignResult run() {
        const auto begin = std::chrono::steady_clock::now();
        const std::clock_t cpu = std::clock();
        result_.seed = options_.seed;
        result_.threads = workers_.count();
        result_.modes = wanted_modes(options_);
        progress_.stage("reading meshes");
        Specimens specimens =
            collect_specimens(options_.places, options_.meshes, options_.most_nodes, options_.folder / "meshes");
        result_.refused = specimens.refused;
        if (specimens.taken.empty()) throw Error("no mesh to stroke: give scenes, meshes or folders of them");
        each_ = std::max<std::size_t>(1, options_.strokes / (specimens.taken.size() * result_.modes.size()));
        all_ = each_ * specimens.taken.size() * result_.modes.size();
        for (const Specimen& specimen : specimens.taken) stroke(specimen);
        progress_.clear();
        result_.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        result_.cpu_s = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
        return result_;
    }

private:
    void stroke(const Specimen& specimen) {
        SpecimenResult one{specimen, {}};
        std::unique_ptr<StrokedBody> body;
        ForceLaw force{};
        try {
            for (const TouchMode& mode : result_.modes) {
                if (!body || mode.force != force) {
                    Progress silent(true);
                    force = mode.force;
                    body.reset();
                    body = std::make_unique<StrokedBody>(
                        in_mode(specimen.scene, {force, GodObject::kNearest, false}),
                        options_.folder / "tables" / (specimen.name + "-" + word(force)), silent);
                }
                one.tally.push_back(stroke(specimen, *body, mode));
            }
        } catch (const Error& error) {
            result_.refused.push_back({specimen.name, error.what()});
            return;
        }
        result_.results.push_back(one);
    }

    Tally stroke(const Specimen& specimen, const StrokedBody& body, const TouchMode& mode) {
        const haptable_model model = body.model(in_mode(specimen.scene, mode).contact);
        const Touched touched = body.touched(model);
        const StrokeMaker maker(body.servo());
        const std::uint64_t seed = seed_of(options_, specimen.name, mode);
        progress_.stage(specimen.name + " " + mode.name());
        const Tally tally = run_strokes(touched, maker, seed, each_, workers_, [&](std::size_t done) {
            progress_.done(static_cast<double>(done_ + done) / static_cast<double>(all_));
        });
        done_ += each_;
        write_examples(specimen, mode, touched, maker, seed, tally);
        return tally;
    }

    /// The first strokes with each fault, shrunk, each beside its scene.
    void write_examples(const Specimen& specimen, const TouchMode& mode, const Touched& touched,
                        const StrokeMaker& maker, std::uint64_t seed, const Tally& tally) {
        for (std::size_t f = 0; f < static_cast<std::size_t>(Fault::kBrake); ++f) {
            std::size_t left = options_.examples;
            for (const Broken& broken : tally.broken) {
                if (left == 0) break;
                if (broken.verdict.tick[f] < 0) continue;
                --left;
                const auto fault = static_cast<Fault>(f);
                const Stroke least = shrink(touched, maker.make(seed, broken.number), fault);
                const fs::path folder = options_.folder / "faults" /
                                        fmt::format("{}-{}-{}-{}-{}", name_of(fault), specimen.name, mode.name(),
                                                    options_.seed, broken.number);
                fs::create_directories(folder);
                write_file(folder / "scene.toml", to_toml(in_mode(specimen.scene, mode)));
                write_file(folder / "stroke.csv", to_csv(least));
                if (!options_.quiet)
                    fmt::print("{}: {} ticks, {} at the last\n", folder.string(), least.size(), name_of(fault));
            }
        }
    }

    const Options& options_;
    Progress progress_;
    Workers workers_;
    std::size_t each_ = 0, all_ = 0, done_ = 0;
    CampaignResult result_;
};

/// One stroke, on one scene as that says: what the judge saw, tick by tick.
void judge_one(const Options& options) {
    if (options.places.size() != 1) throw Error("--judge: give one scene to judge the stroke on");
    Progress progress(options.quiet);
    const Scene scene = read_scene(options.places.front());
    const StrokedBody body(scene, options.folder / "judged" / scene.name, progress);
    const haptable_model model = body.model(scene.contact);
    const Stroke stroke = read_stroke(options.stroke);
    std::vector<Judged> ticks;
    judge(body.touched(model), stroke, &ticks);
    progress.clear();
    fmt::print("{}", to_csv(stroke, ticks));
}

void run(const Options& options) {
    if (!options.stroke.empty()) return judge_one(options);
    const CampaignResult result = Campaign(options).run();
    const Numbers numbers = numbers_of(result);
    if (!options.json.empty()) write_file(options.json, to_json(result).dump(2) + "\n");
    if (!options.numbers.empty()) numbers.write(options.numbers);
    if (options.quiet) return;
    for (const auto& [topic, json] : numbers.json().items()) fmt::print("{}: {}\n", topic, to_markdown(json));
    for (const Refused& refused : result.refused) fmt::print("not stroked: {}\n", refused.why);
}

}  // namespace

int main(int argc, char** argv) {
    CommandLine app("Strokes bodies at random in every mode of contact, and judges every tick.", "haptable-strokes");
    Options options;
    app.option("PLACES", options.places, "scenes, meshes, or folders of them").required();
    app.option("--strokes", options.strokes, "in all").positive().show_default();
    app.option("--seed", options.seed, "of the strokes").show_default();
    app.option("--mesh", options.meshes, "only bodies with this in their name; may be given again");
    app.option("--mode", options.modes, "only modes with this in their name, as consistent-least-energy-friction");
    app.option("--most-nodes", options.most_nodes, "larger meshes are left out").show_default();
    app.option("--examples", options.examples, "strokes of each fault, body and mode that are shrunk and written")
        .show_default();
    app.option("--build", options.folder, "folder for tables and for strokes that broke something").show_default();
    app.option("-o", options.numbers, "write the numbers for the page to this JSON file");
    app.option("--judge", options.stroke, "only judge this stroke, a CSV as the servo's, on one scene in its own mode");
    app.option("--json", options.json, "every count as JSON");
    app.option("--threads", options.threads, "default: all processors; they change no count").range(1, 1024);
    app.flag("--quiet", options.quiet, "no table, no progress bar");
    catch_interrupts();
    return run_program(app, argc, argv, [&] { run(options); });
}
