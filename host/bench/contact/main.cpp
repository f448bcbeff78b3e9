// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-contact: ticks of every contact mode beside those of haptic libraries (host/bench/peers) on the same
// patches, over strokes at up to 0.1 m/s through the surface and aside, in the ticks in which the finger is in contact,
// and round a circle 2 mm above it; and a tool's ticks beside as many proxies as it has points: raw times as JSON, of
// which lab/programs.py makes tables.
#include <dlfcn.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>

#include "firmware/haptable_scene.h"
#include "host/base/error.hpp"
#include "host/base/program.hpp"
#include "host/bench/peers/peer.h"
#include "host/bench/subject.hpp"
#include "host/session/scene_state.hpp"
#include "host/target/modes.hpp"
#include "host/target/strokes.hpp"

namespace haptable {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kStrokes = 50;
constexpr float kLongest_m = 1e-4F;  // a tick: 0.1 m/s
constexpr double kAbove_m = 2e-3;
constexpr std::size_t kRound = 1000;  // ticks of the circle
constexpr double kStiffness_n_per_m = 100.0;
constexpr double kStaticFriction = 0.5, kDynamicFriction = 0.4;  // in_mode()'s

/// What is timed: it begins a stroke at a position, and makes ticks. `pressing`: contacts in the last one.
struct Touched {
    std::function<void(const std::array<float, 3>&)> begin = [](const auto&) {}, to = begin;
    std::function<std::size_t()> pressing = {};
};

/// Strokes one by one, slow enough for a hand.
std::vector<FingerPath> slow_strokes(const Tables& tables) {
    constexpr std::size_t kTicks = 40;
    const FingerPath path = stroke_path(tables, kStrokes);
    std::vector<FingerPath> strokes;
    for (std::size_t i = 0; i < path.size(); i += kTicks) {
        const auto first = path.begin() + static_cast<std::ptrdiff_t>(i);
        strokes.push_back(walked<3>({first, first + kTicks}, kLongest_m));
    }
    return strokes;
}

/// By tick of all strokes: how many contacts press, where some did a tick before; else 0.
std::vector<std::size_t> pressing_in(const Touched& touched, const std::vector<FingerPath>& strokes) {
    std::vector<std::size_t> pressing;
    for (const FingerPath& stroke : strokes) {
        touched.begin(stroke.front());
        std::size_t before = 0;
        for (const auto& x : stroke) {
            touched.to(x);
            const std::size_t now = touched.pressing();
            pressing.push_back(before > 0 ? now : 0);
            before = now;
        }
    }
    return pressing;
}

std::array<double, 3> in_double(const std::array<float, 3>& x) { return {x[0], x[1], x[2]}; }

template <typename Function>
Function* function_of(void* library, const std::filesystem::path& file, const char* name) {
    void* found = dlsym(library, name);
    if (found == nullptr) throw Error(fmt::format("{}: has no {}; run make peers", file.string(), name));
    return reinterpret_cast<Function*>(found);
}

/// A proxy of a peer's library, which stays loaded.
Touched peer_on(const std::filesystem::path& file, const Tables& tables, bool friction) {
    void* library = dlopen(std::filesystem::absolute(file).c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) throw Error(fmt::format("{}; run make peers", dlerror()));
    auto* make = function_of<decltype(haptable_peer_make)>(library, file, "haptable_peer_make");
    auto* begin = function_of<decltype(haptable_peer_begin)>(library, file, "haptable_peer_begin");
    auto* step = function_of<decltype(haptable_peer_step)>(library, file, "haptable_peer_step");
    void* peer =
        make(tables.position.front().data(), tables.patch.front().data(), static_cast<int>(tables.patch.size()),
             kStiffness_n_per_m, friction ? kStaticFriction : 0.0, friction ? kDynamicFriction : 0.0);
    auto force_n = std::make_shared<std::array<double, 3>>();
    return {[=](const auto& x) { begin(peer, in_double(x).data()); },
            [=](const auto& x) { step(peer, in_double(x).data(), force_n->data()); }};
}

Touched servo_on(const haptable_model& model) {
    struct State {
        haptable_model model;
        haptable_room room;
        haptable_output out{};
    };
    auto state = std::make_shared<State>();
    state->model = model;
    return {[state](const auto&) { haptable_servo_init(&state->room.fingers.servo[0]); },
            [state](const auto& x) {
                haptable_servo_step(&state->model, &state->room.fingers.servo[0], x.data(), 0, &state->out);
            },
            [state] { return std::size_t{haptable_touches(state->out.state) != 0}; }};
}

using AllTouched = std::vector<std::pair<std::string, Touched>>;

/// By what is touched the fastest that each tick was in any round, s: all in turn, so that a ratio compares the same
/// minutes. Of the ticks that are kept.
nlohmann::ordered_json fastest_of(const AllTouched& touched, const std::vector<FingerPath>& strokes, int rounds,
                                  const std::function<bool(std::size_t tick)>& is_kept) {
    std::vector<std::vector<double>> fastest_s(touched.size());
    for (int round = 0; round < rounds; ++round)
        for (std::size_t i = 0; i < touched.size(); ++i) {
            std::size_t tick = 0;
            for (const FingerPath& stroke : strokes) {
                touched[i].second.begin(stroke.front());
                for (const auto& x : stroke) {
                    const Clock::time_point begin = Clock::now();
                    touched[i].second.to(x);
                    const double s = std::chrono::duration<double>(Clock::now() - begin).count();
                    if (round == 0) fastest_s[i].push_back(s);
                    fastest_s[i][tick] = std::min(fastest_s[i][tick], s);
                    ++tick;
                }
            }
        }
    nlohmann::ordered_json all;
    for (std::size_t i = 0; i < touched.size(); ++i)
        for (std::size_t tick = 0; tick < fastest_s[i].size(); ++tick)
            if (is_kept(tick)) all[touched[i].first].push_back(fastest_s[i][tick]);
    return all;
}

using Subjects = std::map<ForceLaw, std::unique_ptr<LoadedScene>>;

/// The fastest that each tick in contact, and each above, was in any round, s: of the clock alone, of the peers, and of
/// every mode.
nlohmann::ordered_json times_on(const Subjects& subjects, const std::vector<std::filesystem::path>& peers, int rounds) {
    const LoadedScene& points = *subjects.at(ForceLaw::kInterpolated);
    const Tables& tables = points.tables();
    const std::vector<FingerPath> strokes = slow_strokes(tables);
    AllTouched touched{{"clock", {}}};
    for (const std::filesystem::path& peer : peers)
        for (const bool friction : {false, true})
            touched.emplace_back(peer.stem().string() + (friction ? " friction" : ""), peer_on(peer, tables, friction));
    for (const Mode& mode : every_mode())
        if (mode.more != "passivity")  // no peer has it
            touched.emplace_back(mode.name(), servo_on(in_mode(subjects.at(mode.force)->model(), mode)));
    const auto presses = pressing_in(servo_on(points.model()), strokes);
    const FingerPath round = circle(tables, -kAbove_m, kRound);
    return {{"contact", fastest_of(touched, strokes, rounds, [&](std::size_t tick) { return presses[tick] > 0; })},
            {"above", fastest_of(touched, {round}, rounds, [](std::size_t tick) { return tick > 0; })}};
}

// ---- a tool --------------------------------------------------------------------------------------------------------

/// A tool rolls as its handle goes.
Eigen::Quaternionf turn_at(const std::array<float, 3>& handle_m) {
    constexpr float kRoll_rad_per_m = 20.0F;
    const float angle = kRoll_rad_per_m * (handle_m[0] - handle_m[1] + 0.5F * handle_m[2]);
    return Eigen::Quaternionf(Eigen::AngleAxisf(angle, Eigen::Vector3f(1.0F, 2.0F, 2.0F) / 3.0F));
}

Touched tool_on(const std::shared_ptr<const LoadedScene>& scene) {
    struct State {
        std::optional<SceneState> scene;
        std::uint32_t now_us = 0;
    };
    auto state = std::make_shared<State>();
    return {[=](const auto&) {
                state->scene.emplace(scene->model(), nullptr, nullptr, nullptr, scene->tool());
                state->scene->check(HAPTABLE_CHECK_ALL);
            },
            [state](const auto& handle_m) {
                haptable_tool_input in{};
                haptable_tool_output out;
                const Eigen::Quaternionf turn = turn_at(handle_m);
                std::copy(handle_m.begin(), handle_m.end(), in.hand.finger_m);
                in.hand.is_there = 1;
                in.turn[0] = turn.w();
                for (int c = 0; c < 3; ++c) in.turn[1 + c] = turn.vec()[c];
                state->scene->step(in, state->now_us += HAPTABLE_TICK_US, out);
            },
            [=] {
                std::size_t count = 0;
                for (std::size_t i = 0; i < scene->tool_points().size(); ++i)
                    count += state->scene->point_state(i).presses;
                return count;
            }};
}

/// Proxies that go where the tool's points go, one after the other.
Touched proxies_on(const std::vector<Touched>& proxy, const ToolPoints& points) {
    const auto each = [=](const std::array<float, 3>& x, auto member) {
        const Eigen::Quaternionf turn = turn_at(x);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Eigen::Vector3f at = Eigen::Vector3f(x.data()) + turn * Eigen::Vector3f(points[i].data());
            (proxy[i].*member)({at.x(), at.y(), at.z()});
        }
    };
    return {[=](const auto& x) { each(x, &Touched::begin); }, [=](const auto& x) { each(x, &Touched::to); }};
}

/// The fastest that each tick was in any round, s, in which some point of the tool presses and did before: of the
/// clock, of the tool with each god-object, and of as many proxies of each peer, without friction.
nlohmann::ordered_json tool_times_on(const std::filesystem::path& folder,
                                     const std::vector<std::filesystem::path>& peers, int rounds) {
    SceneFiles files = read_scene_files(folder);
    AllTouched touched{{"clock", {}}};
    std::shared_ptr<const LoadedScene> scene;  // the last one is of the nearest god-object
    for (const GodObject god_object : {GodObject::kLeastEnergy, GodObject::kNearest}) {
        files.tables.god_object = god_object;
        scene = std::make_shared<LoadedScene>(files);
        if (scene->tool() == nullptr) throw Error(folder.string() + ": has no tool: give a scene with [tool]");
        touched.emplace_back(word(god_object), tool_on(scene));
    }
    for (const std::filesystem::path& peer : peers) {
        std::vector<Touched> proxies;
        for ([[maybe_unused]] const auto& point : scene->tool_points())
            proxies.push_back(peer_on(peer, scene->tables(), false));
        touched.emplace_back(peer.stem().string(), proxies_on(proxies, scene->tool_points()));
    }
    const std::vector<FingerPath> strokes = slow_strokes(scene->tables());
    const auto presses = pressing_in(tool_on(scene), strokes);
    const auto count = std::ranges::count_if(presses, [](std::size_t pressing) { return pressing > 0; });
    if (count == 0) throw Error(folder.string() + ": no stroke presses the tool into the body");
    const double sum = std::accumulate(presses.begin(), presses.end(), 0.0);
    return {{"points", scene->tool_points().size()},
            {"pressing", sum / static_cast<double>(count)},
            {"ticks", fastest_of(touched, strokes, rounds, [&](std::size_t tick) { return presses[tick] > 0; })}};
}

}  // namespace

}  // namespace haptable

int main(int argc, char** argv) {
    using namespace haptable;
    CommandLine app("Times the contact modes' ticks beside haptic libraries.", "haptable-contact");
    std::vector<std::filesystem::path> folders, peers;
    std::filesystem::path tool;
    int rounds = 30;
    app.option("DIR", folders, "tables of one body with each force: interpolated, consistent, pressure-mask")
        .required();
    app.option("--peer", peers, "a library of make peers, beside which the modes are timed");
    app.option("--tool", tool, "tables of the body with a tool: its ticks are told, beside as many proxies");
    app.option("--rounds", rounds, "every tick is as fast as it was in any of so many").show_default();
    return run_program(app, argc, argv, [&] {
        Subjects subjects;
        for (const std::filesystem::path& folder : folders) {
            auto subject = std::make_unique<LoadedScene>(read_unlimited(folder));
            subjects[subject->tables().force] = std::move(subject);
        }
        if (folders.size() != 3 || subjects.size() != 3) throw Error("DIR: give three folders, one of each force");
        nlohmann::ordered_json all = times_on(subjects, peers, rounds);
        if (!tool.empty()) all["tool"] = tool_times_on(tool, peers, rounds);
        fmt::print("{}\n", all.dump());
    });
}
