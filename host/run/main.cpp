// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-run: a whole session in one command, and a folder with all that was seen of it.
#include <fmt/format.h>

#include <array>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/finger_advice.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/own_folder.hpp"
#include "host/base/program.hpp"
#include "host/base/shell.hpp"
#include "host/base/summary_lines.hpp"
#include "host/link/messages.hpp"
#include "host/link/text_file.hpp"
#include "host/run/page.hpp"
#include "host/run/plots.hpp"
#include "host/run/report.hpp"
#include "host/run/session.hpp"
#include "host/run/timeline.hpp"
#include "host/scene/scene.hpp"

namespace haptable {

namespace {

struct Options {
    RunOptions run;
    std::string path, device, fault, seed, draw = "pictures";
    double seconds = 0.0;
    int fingers = 0;  ///< hands; 0: as many as the scene has
    bool lockstep = false, json = false;
    std::vector<std::string> more;
};

void add_options(CommandLine& app, Options& o) {
    app.option("SCENE", o.run.scene_file, "the scene file; its servo is made where it is missing").required();
    app.option("-o,--out", o.run.folder,
               "folder of log, CSV, pictures and report: new, empty, or of an earlier session, which is replaced")
        .required();
    app.option("DEVICE_OPTIONS", o.more, "more options of haptable-device, after --: -- --at 0,0,0.03 --depth 0.01");
    app.option("--seconds", o.seconds, "how long [once along the path]").positive();
    app.option("--path", o.path, "as of haptable-device");
    app.option("--device", o.device, "as of haptable-device");
    app.option("--fault", o.fault, "as of haptable-device");
    app.option("--seed", o.seed, "as of haptable-device");
    app.option("--fingers", o.fingers, "hands of the device [as many as the scene has]")
        .range(1, static_cast<int>(kFingers));
    app.flag("--lockstep", o.lockstep, "as of haptable-device");
    app.option("--target", o.run.target,
               "the servo on a microcontroller in QEMU: cortex-m4, cortex-m7, cortex-m33, rv32");
    app.option("--draw", o.draw, "pictures, film or nothing when it is over, or pictures while it runs: live")
        .show_default();
    app.option("--every", o.run.every_ms, "ms from picture to picture").range(1, 1000000).show_default();
    app.flag("--no-realtime", o.run.no_realtime, "do not ask for real-time priority");
    app.flag("--json", o.json, "print the summary as JSON");
    app.flag("--quiet", o.run.quiet, "print nothing but errors (and what --json asks for)");
}

std::vector<std::string> device_words(const Options& o) {
    std::vector<std::string> words;
    const auto add = [&words](const char* name, const std::string& value) {
        if (!value.empty()) words.insert(words.end(), {name, value});
    };
    add("--path", o.path);
    add("--device", o.device);
    add("--fault", o.fault);
    add("--seed", o.seed);
    if (o.fingers > 1) add("--fingers", std::to_string(o.fingers));
    if (o.seconds > 0.0) add("--seconds", fmt::format("{:.9g}", o.seconds));
    if (o.lockstep) words.emplace_back("--lockstep");
    words.insert(words.end(), o.more.begin(), o.more.end());
    return words;
}

void check(const Options& o) {
    for (const char* word : {"pictures", "film", "nothing", "live"})
        if (o.draw == word) return;
    throw BadCommandLine("--draw: \"" + o.draw + "\" is none of pictures, film, nothing, live");
}

constexpr std::array kWritten{"session.lcmlog", "servo.csv",    "device.csv",   "device_2.csv", "device_3.csv",
                              "device_4.csv",   "device_5.csv", "device_6.csv", "device_7.csv", "device_8.csv",
                              "session.csv",    "report.html",  "summary.json", "servo.json",   "device.json",
                              "session.mp4",    "to-target",    "from-target"};

/// What earlier sessions left goes; the folder's own pictures are the viewer's.
void clear(OwnFolder& folder) {
    const std::filesystem::path pictures = folder.path() / "pictures";
    if (std::filesystem::exists(pictures)) OwnFolder(pictures, kPictures).clear();
    for (const char* written : kWritten) folder.file(written);
    folder.clear();
}

void run(Options& o) {
    check(o);
    catch_interrupts();
    o.run.scene_file = no_option(o.run.scene_file);
    const Scene scene = read_scene(o.run.scene_file);
    for (const char* written : kWritten)
        if (!o.path.empty()) require_other_file(o.run.folder / written, o.path, "--path");
    OwnFolder folder(o.run.folder, kSession);
    const Places places = find_places(o.run.scene_file, scene.name, o.run.target, o.run.quiet);
    clear(folder);
    if (o.fingers == 0) o.fingers = scene.contact.fingers;
    o.run.device = device_words(o);
    o.run.live = o.draw == "live";
    const RunOutcome outcome = run_session(places, o.run);
    const SummaryLines summary = report(places, o.run, scene.name, outcome, o.draw);
    summary.print(o.json, o.run.quiet);
    const ContactOptions& contact = scene.contact;
    if (contact.force == ForceLaw::kInterpolated && contact.god_object == GodObject::kNearest && !o.json &&
        !o.run.quiet)
        fmt::print("{}", finger_advice());
    if (!outcome.trouble.empty())
        throw Error(fmt::format("{}; the record up to there is in {}", outcome.trouble, o.run.folder.string()));
    if (outcome.interrupted) throw Interrupted();
}

}  // namespace

}  // namespace haptable

int main(int argc, char** argv) {
    haptable::CommandLine app(
        "A session in one command: starts and ends servo, device, logger and viewer, and reports.", "haptable-run");
    haptable::Options options;
    haptable::add_options(app, options);
    return haptable::run_program(app, argc, argv, [&] { haptable::run(options); });
}
