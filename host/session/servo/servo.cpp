// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/session/servo/servo.hpp"

#include <fmt/format.h>

#include <optional>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/finger_advice.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/program.hpp"
#include "host/base/summary_lines.hpp"
#include "host/link/realtime.hpp"
#include "host/link/text_file.hpp"
#include "host/session/serve.hpp"
#include "host/session/servo/poke.hpp"
#include "host/session/servo/replay.hpp"

namespace haptable {

namespace {

constexpr int kPriority = 50;  // of 1..99: above all normal work, below the kernel's own

struct Options {
    bool lcm = false;
    std::string in, out, csv, tables, poke;
    Poke where;
    SessionEnd end;
    bool no_realtime = false;
    bool check = false;
    bool json = false;
    bool quiet = false;
};

void add_options(CommandLine& app, Options& o) {
    const Option in = app.option("--replay", o.in,
                                 "run what IN holds: a finger path (x,y,z in metres, one line a ms), a servo's CSV, or "
                                 "the LCM log of a session");
    const Option out = app.option("--out", o.out, "with --replay: write the servo's CSV here");
    const Option lcm = app.flag("--lcm", o.lcm, "join a device over LCM (LCM_DEFAULT_URL is honoured)");
    const Option push =
        app.option("--poke", o.poke, "push the finger in at X,Y,Z, in metres, or at the top, and print what it feels");
    push.excludes(lcm).excludes(in);
    const auto set = [&o](const std::vector<double>& v) { o.where.direction = Eigen::Vector3d(v[0], v[1], v[2]); };
    app.numbers("--direction", set, "of --poke [0,0,-1]").delimiter(',').count(3).values_name("X,Y,Z").needs(push);
    app.option("--depth", o.where.depth_m, "m, of --poke").positive().show_default().needs(push);
    in.excludes(lcm);
    out.needs(in);
    app.flag("--check", o.check, "with --replay of a log: other forces than the log's, be it in one bit, are an error")
        .needs(in);
    app.option("--tables", o.tables,
               "with --replay: the tables_hash of the session that recorded IN; other tables are an error; \"any\": "
               "those that a log names need not be this servo's")
        .needs(in);
    app.option("--csv", o.csv, "with --lcm: record the session here, as --replay writes it").needs(lcm);
    app.option("--seconds", o.end.after_s, "with --lcm: end after this time").needs(lcm).positive();
    app.option("--until-silent", o.end.until_silent_s,
               "with --lcm: end when the device was silent for this many seconds")
        .needs(lcm)
        .positive();
    app.flag("--no-realtime", o.no_realtime, "with --lcm: do not ask for real-time priority").needs(lcm);
    app.flag("--json", o.json, "print the summary as JSON");
    app.flag("--quiet", o.quiet, "print nothing but errors (and what --json asks for)");
}

/// suffix: of the finger, at the end of each name.
void add_report(const ServoReport& report, const std::string& suffix, SummaryLines& summary) {
#define HAPTABLE_ADD(name) summary.add(#name + suffix, std::int64_t{report.counters.name});
    HAPTABLE_COUNTERS(HAPTABLE_ADD)
#undef HAPTABLE_ADD
    report.add_to(summary, suffix);
    if (report.step.count() == 0) return;
    summary.add("step_mean_us", report.step.mean_us());
    summary.add("step_p999_us", report.step.quantile_us(0.999));
    summary.add("step_max_us", report.step.max_us());
}

std::string tables_hash(const ServoScene& scene) { return fmt::format("{:016x}", scene.model->hash); }

SummaryLines head(const ServoScene& scene) {
    SummaryLines summary;
    summary.add("scene", std::string(scene.name));
    summary.add("tables_hash", tables_hash(scene));
    return summary;
}

void require_tables(const ServoScene& scene, const Options& o, std::uint64_t of_log) {
    std::string wanted = o.tables;
    if (wanted.empty() && of_log != 0) wanted = fmt::format("{:016x}", of_log);
    if (wanted.empty() || wanted == "any" || wanted == tables_hash(scene)) return;
    throw Error(
        fmt::format("{}: was recorded with the tables {}, and this servo has {}: its forces may be others, be it "
                    "in the last bit; take the servo of those tables, or {}",
                    o.in, wanted, tables_hash(scene), o.tables.empty() ? "give --tables any" : "leave out --tables"));
}

void require_places(const Options& o) {
    if (o.out.empty() && !o.check) throw BadCommandLine("--replay: give --out OUT.csv, or --check for a log");
    if (!o.out.empty()) require_other_file(o.out, o.in, "--replay");
}

void require_same(const Options& o, const ReplayReport& report) {
    if (!o.check) return;
    if (report.compared == 0)
        throw Error(o.in + ": has no forces to compare with: --check is for the log of a session");
    if (report.other_forces > 0)
        throw Error(fmt::format("{}: {} of {} forces are others than the log's, the first at tick {}", o.in,
                                report.other_forces, report.compared, report.first_other));
}

/// Why a path was not felt: it leaps, which no finger does, or is elsewhere.
void tell_no_contact(const ServoScene& scene, const Options& o, std::uint32_t implausible) {
    const std::string leaps = implausible == 0
                                  ? ""
                                  : fmt::format(
                                        "; {} of its positions leap farther than max_speed allows in a tick and were "
                                        "left out: give one a millisecond",
                                        implausible);
    fmt::print(stderr, "servo: note: {} never meets the body: {}{}\n", o.in, where_it_is(*scene.model), leaps);
}

void run_replay(const ServoScene& scene, const Options& o) {
    catch_interrupts();
    require_places(o);
    const Recording recording = read_recording(o.in);
    require_tables(scene, o, recording.tables_hash);
    const ReplayReport report = replay(scene, recording, o.out, o.quiet);
    if (report.counters.contact_ticks == 0 && !o.quiet) tell_no_contact(scene, o, report.counters.implausible);
    SummaryLines summary = head(scene);
    add_report(report, "", summary);
    for (std::size_t i = 0; i < report.others.size(); ++i) add_report(report.others[i], kFingerSuffix[i + 1], summary);
    if (!report.others.empty()) summary.add("energy_most_given_to_both_j", report.most_given_j);
    if (report.compared > 0) {
        summary.add("compared_forces", report.compared);
        summary.add("other_forces", report.other_forces);
    }
    summary.print(o.json, o.quiet);
    require_same(o, report);
}

std::string numbers_of(const Eigen::Vector3d& v) { return fmt::format("{:.6g} {:.6g} {:.6g}", v.x(), v.y(), v.z()); }

void run_poke(const ServoScene& scene, Options o) {
    o.where.at_m = place_of(o.poke, *scene.model);
    const Poked end = poke(scene, o.where);
    SummaryLines summary = head(scene);
    summary.add("at_m", numbers_of(o.where.at_m));
    summary.add("finger_m", numbers_of(end.finger_m));
    summary.add("god_object_m", numbers_of(end.god_object_m));
    summary.add("nodes", fmt::format("{} {} {}", end.node[0], end.node[1], end.node[2]));
    summary.add("depth_m", end.depth_m);
    summary.add("force_n", numbers_of(end.force_n));
    summary.add("force_size_n", end.force_n.norm());
    summary.add("stiffness_n_per_m", end.force_n.norm() / end.depth_m);
    summary.print(o.json, o.quiet);
    const bool is_point = scene.model->compliance == nullptr && scene.model->energy == nullptr;
    if (is_point && !o.json && !o.quiet) fmt::print("{}", finger_advice());
}

void run_lcm(const ServoScene& scene, const Options& o) {
    catch_interrupts();
    const std::string priority = o.no_realtime ? "normal priority" : ask_for_real_time(kPriority);
    std::optional<ServoRecord> record;
    if (!o.csv.empty()) record.emplace(scene, o.csv).keep();
    Connection connection;
    LocalStepper stepper(scene);
    Session session(stepper, connection, record ? &*record : nullptr, teller("servo", o.quiet));
    const bool locked = !o.no_realtime && lock_memory();
    if (!o.quiet)
        fmt::print(stderr, "servo: {} on {}, {}, memory {}\n", scene.name, connection.url(), priority,
                   locked ? "locked" : "not locked");
    serve(session, o.end, [&](Clock::time_point deadline) { connection.handle_until(deadline); });
    if (record) record->finish();
    SummaryLines summary = head(scene);
    summary.add("url", connection.url());
    for (std::size_t finger = 0; finger < stepper.finger_count(); ++finger) {
        add_report(stepper.report(finger), kFingerSuffix[finger], summary);
        add_link_report(session.link_report(finger), kFingerSuffix[finger], summary);
    }
    if (stepper.finger_count() == 2) summary.add("energy_most_given_to_both_j", stepper.most_given_j());
    summary.print(o.json, o.quiet);
}

}  // namespace

int servo_main(int argc, char** argv, const ServoScene& scene) {
    CommandLine app(fmt::format("The servo of the scene \"{}\": feels a finger at 1 kHz.", scene.name), "servo");
    Options options;
    add_options(app, options);
    return run_program(app, argc, argv, [&] {
        if (!options.lcm && options.in.empty() && options.poke.empty())
            throw BadCommandLine("nothing to do: give --lcm, --replay IN.csv --out OUT.csv, or --poke X,Y,Z");
        if (!options.poke.empty())
            run_poke(scene, options);
        else if (options.lcm)
            run_lcm(scene, options);
        else
            run_replay(scene, options);
    });
}

}  // namespace haptable
