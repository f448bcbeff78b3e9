// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-device: a simulated haptic device, held by a simulated hand, over LCM.
#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/installed.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/program.hpp"
#include "host/base/summary_lines.hpp"
#include "host/device/drivers.hpp"
#include "host/device/session.hpp"
#include "host/device/simulated_driver.hpp"
#include "host/device/touchable.hpp"
#include "host/link/finger_path.hpp"
#include "host/link/messages.hpp"
#include "host/link/realtime.hpp"
#include "host/link/text_file.hpp"
#include "host/scene/device_models.hpp"
#include "host/scene/scene.hpp"
#include "host/tables/tool.hpp"

namespace haptable {

namespace {

constexpr std::uint64_t kHandSeeds = 10;  // a hand's faults have dice of their own, some of them

constexpr int kPriority = 49;  // just below the servo's: its answer is what we wait for

struct Options {
    std::string scene, faults, path = "poke", csv, device, hand_name = "default", press, driver = "simulated";
    std::filesystem::path tables;  ///< folder; empty: build/<name> above this program's own
    DriverOptions real;
    PathOptions geometry;
    std::optional<Eigen::Vector3d> at_m, direction;                       ///< empty: of this scene's surface
    std::optional<Eigen::Vector3d> second_at_m, second_direction;         ///< of the second hand
    int fingers = 1, finger = 1;                                          ///< hands; which finger a single one is
    double hand_stiffness_n_per_m = -1.0, hand_damping_n_s_per_m = -1.0;  ///< less than 0: as the hand of that name
    SessionOptions session;
    bool no_realtime = false;
    bool json = false;
    bool quiet = false;
};

/// An option of three numbers with commas between them. Vector: Eigen's, or an optional one.
template <typename Vector>
void add_vector(CommandLine& app, const std::string& name, Vector& value, const std::string& text) {
    const auto set = [&value](const std::vector<double>& v) { value = Eigen::Vector3d(v[0], v[1], v[2]); };
    app.numbers(name, set, text).delimiter(',').count(3).values_name("X,Y,Z");
}

void add_path_options(CommandLine& app, Options& o) {
    app.option(
           "--path", o.path,
           "where the hand goes: poke, drag, circle, lift, with a tool also roll and tilt, several with commas "
           "between them, or FILE.csv (x,y,z, of more fingers x,y,z,x2,y2,z2 and on, of a tool x,y,z,qw,qx,qy,qz, in "
           "metres, one line a ms)")
        .show_default();
    add_vector(app, "--at", o.at_m,
               "m, where the surface is touched [the touchable surface nearest to its top's centre]");
    add_vector(app, "--direction", o.direction, "into the body [0,0,-1, or inwards where that is not under the top]");
    app.option("--fingers", o.fingers, "hands, of a scene with as many fingers, around the body, the path for all")
        .range(1, static_cast<int>(kFingers))
        .show_default();
    app.option("--finger", o.finger, "which finger of the scene this device is; other devices are the others")
        .range(1, static_cast<int>(kFingers))
        .show_default();
    add_vector(app, "--at2", o.second_at_m, "m, where the second hand touches [the side opposite to the first's]");
    add_vector(app, "--direction2", o.second_direction, "into the body, of the second hand");
    app.option("--tables", o.tables, "folder of this scene's tables, which tell where the body is [build/<name>]");
    add_vector(app, "--along", o.geometry.along, "of the drag [the axis that lies flattest]");
    const auto length = [&app](const char* name, double& value, const char* text) {
        app.option(name, value, text).non_negative().show_default();
    };
    length("--depth", o.geometry.depth_m, "m, of the hand's target below the surface");
    length("--radius", o.geometry.radius_m, "m, of the circle; half the length of the drag");
    length("--clearance", o.geometry.clearance_m, "m, of the start above the surface");
    length("--hold", o.geometry.hold_s, "s, that a poke stays down, a lift up");
    length("--lift", o.geometry.lift_m, "m, of a lift, along z");
    length("--turn", o.geometry.turn_deg, "degrees to each side, that roll and tilt turn a tool");
    app.option("--speed", o.geometry.speed_m_s, "m/s, mean of every movement").positive().show_default();
    app.option("--hand", o.hand_name, "that holds the device: default, soft or stiff").show_default();
    app.option("--hand-stiffness", o.hand_stiffness_n_per_m, "N/m, of that hand [200]").non_negative();
    app.option("--hand-damping", o.hand_damping_n_s_per_m, "N s/m, of that hand [5]").non_negative();
    app.option("--press", o.press,
               "buttons that the hand holds, BUTTON:FROM:TO in seconds, several with commas between "
               "them: clutch:0.5:0.8");
}

void add_options(CommandLine& app, Options& o) {
    app.option("SCENE", o.scene, "the scene file: its [device] gives mass, friction, encoder and force limit")
        .required();
    app.option("--driver", o.driver, "simulated, or a real device: " + driver_names() + " (docs/DEVICES.md)")
        .show_default();
    app.option("--port", o.real.port, "of hapi and falcon: its serial port, such as /dev/ttyACM0");
    app.option("--url", o.real.url, "of inverse3: Haply's service").show_default();
    app.option("--hardware", o.real.hardware, "of hapi: 3 for the plastic 2diy, 2 for the metal one").show_default();
    app.option("--device", o.device, "what is simulated, by a name of docs/DEVICES.md, such as touch [the scene's]");
    add_path_options(app, o);
    app.flag("--lockstep", o.session.lockstep,
             "the clock waits for every answer: deterministic, and faster than real time");
    app.option("--seconds", o.session.seconds, "how long; beyond its end the path is repeated [once along the path]")
        .positive();
    app.option("--patience", o.session.patience_s, "s, to wait for a servo; 0: do not wait")
        .non_negative()
        .show_default();
    const Option fault = app.option("--fault", o.faults,
                                    "what goes wrong on purpose: drop=0.01,delay=20ms,jump=0.001:25mm and others of "
                                    "docs/SPEC.md");
    app.option("--seed", o.session.seed, "of the faults' dice").needs(fault).show_default();
    app.option("--csv", o.csv, "write the device's own record here");
    app.flag("--no-realtime", o.no_realtime, "do not ask for real-time priority");
    app.flag("--json", o.json, "print the summary as JSON");
    app.flag("--quiet", o.quiet, "print nothing but errors (and what --json asks for)");
}

bool is_recorded(const Options& o) { return std::filesystem::path(o.path).extension() == ".csv"; }

std::filesystem::path tables_folder(const Options& o, const Scene& scene) {
    if (!o.tables.empty()) return o.tables;
    return scenes_folder() / scene.name;
}

/// Nothing where the tables are not needed and there are none.
std::optional<Touchable> find_body(const Options& o, const Scene& scene) {
    const std::filesystem::path folder = tables_folder(o, scene);
    if (std::filesystem::exists(folder / "patch.npy")) return read_touchable(folder);
    const bool must = !o.tables.empty() || !(o.at_m || is_recorded(o));
    if (must)
        throw Error(
            fmt::format("{}: has no tables that tell where {} may be touched: make them (make scene), name "
                        "their folder with --tables, or give --at X,Y,Z",
                        folder.string(), scene.name));
    return {};
}

/// A hand of this program, and where it goes.
struct HandPlan {
    std::size_t finger = 0;
    PathOptions geometry;
    std::unique_ptr<Path> path;
};

std::string text_of(const Eigen::Vector3d& v) {
    const Eigen::Vector3d x = v.array() + 0.0;  // no -0
    return fmt::format("{:.4g},{:.4g},{:.4g}", x.x(), x.y(), x.z());
}

/// Without --at: this scene's touchable surface, and says so.
void choose_place(const Options& o, const std::optional<Touchable>& body, PathOptions& geometry) {
    if (o.at_m) geometry.at_m = *o.at_m;
    if (o.direction) geometry.direction = *o.direction;
    if (o.at_m || is_recorded(o)) return;
    const TouchPlace place = top_of(*body);
    geometry.at_m = place.at_m;
    if (!o.direction) geometry.direction = place.direction;
    if (!o.quiet)
        fmt::print(stderr, "haptable-device: presses at {} m, {}, along {} (--at, --direction)\n",
                   text_of(geometry.at_m),
                   place.is_under_top ? "the touchable surface under the centre of its top"
                                      : "the touchable point nearest to the centre of the top",
                   text_of(geometry.direction));
}

/// Lets hands pinch.
void choose_sides(const Options& o, const std::optional<Touchable>& body, std::vector<HandPlan>& hands) {
    static const std::optional<Eigen::Vector3d> kNone;
    if (is_recorded(o)) return;
    if (o.at_m.has_value() != o.second_at_m.has_value() || (o.at_m && hands.size() > 2))
        throw Error(
            "--at and --at2: give the places of two hands, or neither, and the hands press from all sides; or name a "
            "FILE.csv of positions");
    std::vector<TouchPlace> places(hands.size());
    if (!o.at_m) places = sides_of(*body, hands.size());
    for (HandPlan& hand : hands) {
        const auto& at_m = hand.finger == 0 ? o.at_m : o.second_at_m;
        const auto& direction = hand.finger == 0 ? o.direction : hand.finger == 1 ? o.second_direction : kNone;
        if (!at_m) hand.geometry.at_m = places[hand.finger].at_m;
        if (at_m) hand.geometry.at_m = *at_m;
        if (!at_m) hand.geometry.direction = places[hand.finger].direction;
        if (direction) hand.geometry.direction = *direction;
        if (!o.quiet && !at_m)
            fmt::print(stderr,
                       "haptable-device: finger {} presses at {} m along {} (--at, --at2, --direction, "
                       "--direction2)\n",
                       hand.finger + 1, text_of(hand.geometry.at_m), text_of(hand.geometry.direction));
    }
}

std::unique_ptr<Path> make_path(const Options& o, const HandPlan& hand) {
    if (!is_recorded(o)) return scripted_path(o.path, hand.geometry);
    const std::vector<FingerTick> ticks = read_finger_ticks(o.path, Positions::finite);
    std::vector<FingerTick> its = ticks_of(ticks, hand.finger);
    // A path of one finger is any finger's.
    const bool is_of_one = !ticks.empty() && ticks.front().others.empty();
    if (its.empty() && is_of_one && o.fingers == 1) its = ticks;
    if (its.empty() && !ticks.empty())
        throw Error(
            fmt::format("{}: has no place of finger {}: its header is to be x,y,z,x2,y2,z2 and on; or give --fingers 1",
                        o.path, hand.finger + 1));
    return recorded_path(std::move(its));
}

/// From a tool's handle to the point of it that is farthest along its -z.
double reach_of(const std::vector<std::array<double, 3>>& point_m) {
    double reach_m = 0.0;
    for (const auto& p : point_m) reach_m = std::max(reach_m, -p[2]);
    return reach_m;
}

/// A tool's points are in its tables, and of a scene that gives them in the scene too.
void find_tool(const Options& o, const Scene& scene, PathOptions& geometry) {
    if (!scene.tool) return;
    const std::filesystem::path folder = tables_folder(o, scene);
    const auto tool = std::filesystem::exists(folder / "tool.json") ? read_tool(folder) : std::nullopt;
    geometry.reach_m = reach_of(tool ? tool->point_m : scene.tool->point_m);
}

std::vector<HandPlan> plan_hands(const Options& o, const std::optional<Touchable>& body) {
    std::vector<HandPlan> hands(static_cast<std::size_t>(o.fingers));
    for (std::size_t k = 0; k < hands.size(); ++k) {
        hands[k].finger = o.fingers > 1 ? k : static_cast<std::size_t>(o.finger - 1);
        hands[k].geometry = o.geometry;
    }
    if (o.fingers > 1)
        choose_sides(o, body, hands);
    else
        choose_place(o, body, hands[0].geometry);
    for (HandPlan& hand : hands) hand.path = make_path(o, hand);
    return hands;
}

/// A path that missed the body is seldom meant.
void tell_of_miss(const Options& o, std::size_t finger, const DeviceReport& report,
                  const std::optional<Touchable>& body) {
    if (o.quiet || report.contact_ticks > 0 || report.latency.count() == 0) return;  // no servo: no miss
    fmt::print(stderr, "haptable-device: {} never met the body{}\n",
               o.fingers == 1 ? "the finger" : fmt::format("finger {}", finger + 1),
               body ? ": " + where_it_is(*body) : ", and no tables tell where it is (--tables)");
}

Device device_of(const Options& o, const Scene& scene) {
    if (o.device.empty()) return scene.device;
    if (const DeviceModel* model = find_device_model(o.device)) return device_of(*model);
    std::string known;
    for (const DeviceModel& model : device_models()) known += (known.empty() ? "" : ", ") + std::string(model.name);
    throw BadCommandLine(fmt::format("--device: there is no {}; there are {}", o.device, known));
}

Hand hand_of(const Options& o) {
    Hand hand = hand_named(o.hand_name);
    if (o.hand_stiffness_n_per_m >= 0.0) hand.stiffness_n_per_m = o.hand_stiffness_n_per_m;
    if (o.hand_damping_n_s_per_m >= 0.0) hand.damping_n_s_per_m = o.hand_damping_n_s_per_m;
    return hand;
}

std::unique_ptr<Driver> make_driver(const Options& o, const Scene& scene, const Device& device, const Path& path) {
    const DeviceMapping mapping(scene.device_map);
    if (o.driver == "simulated")
        return std::make_unique<SimulatedDriver>(
            PointDevice(device, hand_of(o), mapping.to_device(path.at(0.0).position_m)), path, mapping,
            presses_of(o.press));
    if (o.session.lockstep) throw BadCommandLine("--lockstep: a real device does not wait: leave it out, or --driver");
    if (o.fingers > 1)
        throw BadCommandLine(
            "--fingers: is for simulated hands: start a haptable-device --finger 1, one --finger 2 and so on");
    DriverOptions real = o.real;
    real.max_force_n = device.max_force_n;
    return open_driver(o.driver, real);
}

void add_report(const DeviceReport& report, const std::optional<Touchable>& body, const Driver& driver,
                const std::string& suffix, SummaryLines& summary) {
    for (const Counter& counter : driver.counters()) summary.add(counter.name + suffix, counter.value);
    const auto count = [&](const char* name, std::int64_t value) { summary.add(name + suffix, value); };
    const auto number = [&](const char* name, double value) { summary.add(name + suffix, value); };
    count("ticks", report.ticks);
    count("missed", report.missed);
    count("late_ticks", report.late_ticks);
    count("resent", report.resent);
    count("silences", report.silences);
    count("foreign_answers", report.foreign_answers);
    count("other_device_answers", report.other_device_answers);
    count("refused_answers", report.refused_answers);
    count("stale_answers", report.stale_answers);
    count("contact_ticks", report.contact_ticks);
    if (report.contact_ticks == 0 && report.latency.count() > 0 && body)
        summary.add("never_met" + suffix, where_it_is(*body));
    count("clutched_ticks", report.clutched_ticks);
    number("latency_mean_us", report.latency.mean_us());
    number("latency_p999_us", report.latency.quantile_us(0.999));
    number("latency_max_us", report.latency.max_us());
    number("force_age_mean_us", report.force_age.mean_us());
    number("force_age_p999_us", report.force_age.quantile_us(0.999));
    number("force_age_max_us", report.force_age.max_us());
    number("largest_force_n", report.largest_force_n);
    number("wall_s", report.wall_s);
}

/// A hand at work: its driver, record and session.
struct HandAtWork {
    std::unique_ptr<Driver> driver;
    std::optional<DeviceRecord> record;
    std::unique_ptr<DeviceSession> session;
};

/// The record of a hand; the others' beside the first's: device_2.csv.
std::filesystem::path record_of(const Options& o, std::size_t hand) {
    std::filesystem::path first = o.csv;
    if (hand == 0) return first;
    return first.parent_path() / (first.stem().string() + kFingerSuffix[hand] + first.extension().string());
}

SummaryLines run_hands(const Options& o, const Scene& scene, const Device& device, const std::optional<Touchable>& body,
                       const std::vector<HandPlan>& plans) {
    // In lockstep nothing is urgent, and a busy pair at real-time priority would starve the machine.
    const bool urgent = !o.no_realtime && !o.session.lockstep;
    const std::string priority = urgent ? ask_for_real_time(kPriority) : "normal priority";
    Connection connection;
    std::vector<HandAtWork> hands(plans.size());
    std::vector<DeviceSession*> sessions;
    for (std::size_t k = 0; k < plans.size(); ++k) {
        SessionOptions options = o.session;
        options.tell =
            teller(o.fingers == 1 ? "haptable-device" : fmt::format("haptable-device: finger {}", k + 1), o.quiet);
        options.finger = plans[k].finger;
        options.seed += kHandSeeds * k;
        if (!o.csv.empty()) hands[k].record.emplace(record_of(o, k), scene.tool.has_value()).keep();
        hands[k].driver = make_driver(o, scene, device, *plans[k].path);
        hands[k].session = std::make_unique<DeviceSession>(*hands[k].driver, connection, options,
                                                           hands[k].record ? &*hands[k].record : nullptr);
        sessions.push_back(hands[k].session.get());
    }
    const bool locked = urgent && lock_memory();
    if (!o.quiet)
        fmt::print(stderr, "haptable-device: {} {} at {} on {}, {}, {}, memory {}\n", device.model, o.driver,
                   scene.name, connection.url(), o.session.lockstep ? "lockstep" : "real time", priority,
                   locked ? "locked" : "not locked");
    run_together(sessions);
    SummaryLines summary;
    summary.add("scene", scene.name);
    summary.add("driver", o.driver);
    summary.add("device", device.model);
    summary.add("url", connection.url());
    for (std::size_t k = 0; k < hands.size(); ++k) {
        if (hands[k].record) hands[k].record->finish();
        tell_of_miss(o, plans[k].finger, sessions[k]->report(), body);
        if (scene.tool) summary.add("largest_torque_n_m", sessions[k]->report().largest_torque_n_m);
        add_report(sessions[k]->report(), body, *hands[k].driver, kFingerSuffix[k], summary);
    }
    return summary;
}

void run(Options& o) {
    catch_interrupts();
    const Scene scene = read_scene(o.scene);
    if (!o.faults.empty()) o.session.faults = parse_faults(o.faults);
    const Device device = device_of(o, scene);
    o.session.map = scene.device_map;
    o.session.has_tool = scene.tool.has_value();
    find_tool(o, scene, o.geometry);
    if (std::max(o.fingers, o.finger) > scene.contact.fingers)
        throw Error(fmt::format("{}: has {} of the {} fingers: write fingers = {} in [contact], or leave out --fingers",
                                scene.file.string(), scene.contact.fingers, std::max(o.fingers, o.finger),
                                std::max(o.fingers, o.finger)));
    const std::optional<Touchable> body = find_body(o, scene);
    if (body) o.session.model_hash = tables_hash_in(tables_folder(o, scene));
    const std::vector<HandPlan> hands = plan_hands(o, body);
    if (!o.csv.empty()) require_other_file(o.csv, o.path, "--path");
    run_hands(o, scene, device, body, hands).print(o.json, o.quiet);
}

}  // namespace

}  // namespace haptable

int main(int argc, char** argv) {
    haptable::CommandLine app("A simulated haptic device: a point mass in a simulated hand, over LCM.",
                              "haptable-device");
    haptable::Options options;
    haptable::add_options(app, options);
    return haptable::run_program(app, argc, argv, [&] { haptable::run(options); });
}
