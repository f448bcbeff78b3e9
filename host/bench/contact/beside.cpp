// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/contact/beside.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <limits>
#include <numeric>

#include "firmware/haptable_scene.h"
#include "host/bench/contact/bodies.hpp"
#include "host/bench/proxy/finger_proxy.hpp"
#include "host/bench/proxy/shell_proxy.hpp"
#include "host/target/modes.hpp"
#include "host/target/strokes.hpp"

namespace haptable {

namespace {

using Eigen::Vector3d;
using Clock = std::chrono::steady_clock;

constexpr int kStrokes = 50;
constexpr float kLongest_m = 1e-4F;  // a tick: 0.1 m/s
constexpr double kRadius_m = 1e-4;   // of the proxy
constexpr double kStiffness_n_per_m = 100.0;
constexpr double kStaticFriction = 0.5, kDynamicFriction = 0.4;  // in_mode()'s

/// What is timed: it begins a stroke at a position, and makes ticks.
struct Touched {
    std::function<void(const std::array<float, 3>&)> begin, to;
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

/// By tick of all strokes: 1 where the paper's mode is in contact and was a tick before.
std::vector<char> contact_ticks(haptable_model model, const std::vector<FingerPath>& strokes) {
    std::vector<char> touches;
    for (const FingerPath& stroke : strokes) {
        haptable_servo servo;
        haptable_output out{};
        haptable_servo_init(&servo);
        bool before = false;
        for (const auto& finger_m : stroke) {
            haptable_servo_step(&model, &servo, finger_m.data(), 0, &out);
            const bool now = haptable_touches(out.state) != 0;
            touches.push_back(before && now ? 1 : 0);
            before = now;
        }
    }
    return touches;
}

/// Every tick of a round into its fastest so far, s.
void time_round(const Touched& touched, const std::vector<FingerPath>& strokes, std::vector<double>& fastest_s) {
    std::size_t tick = 0;
    for (const FingerPath& stroke : strokes) {
        touched.begin(stroke.front());
        for (const auto& finger_m : stroke) {
            const Clock::time_point begin = Clock::now();
            touched.to(finger_m);
            const double s = std::chrono::duration<double>(Clock::now() - begin).count();
            fastest_s[tick] = std::min(fastest_s[tick], s);
            ++tick;
        }
    }
}

/// Of the contact ticks. A proxy's alternate between short and long searches: its median is not its mean.
struct Times {
    double mean_s, median_s, most_s;  ///< 99.9 % of the ticks take at most most_s
};

Times times_of(const std::vector<double>& fastest_s, const std::vector<char>& counts, double clock_s) {
    std::vector<double> s;
    for (std::size_t i = 0; i < counts.size(); ++i)
        if (counts[i] != 0) s.push_back(fastest_s[i] - clock_s);
    const auto quantile = [&](double fraction) {
        const auto at = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(s.size() - 1));
        std::nth_element(s.begin(), s.begin() + at, s.end());
        return s[static_cast<std::size_t>(at)];
    };
    const double mean_s = std::accumulate(s.begin(), s.end(), 0.0) / static_cast<double>(s.size());
    return {mean_s, quantile(0.5), quantile(0.999)};
}

template <typename Proxy, typename... Friction>
Touched proxy_on(const Tables& tables, Friction... friction) {
    std::vector<Vector3d> point_m;
    for (const auto& p : tables.position) point_m.emplace_back(p[0], p[1], p[2]);
    auto proxy = std::make_shared<Proxy>(point_m, tables.patch, kRadius_m, friction...);
    auto force_n = std::make_shared<Vector3d>();
    const auto at = [](const std::array<float, 3>& x) {
        return Eigen::Map<const Eigen::Vector3f>(x.data()).cast<double>();
    };
    return {[proxy, at](const auto& x) { proxy->begin(at(x)); },
            [proxy, at, force_n](const auto& x) {
                const Vector3d finger_m = at(x);
                *force_n = kStiffness_n_per_m * (proxy->to(finger_m) - finger_m);
            }};
}

Touched servo_on(const haptable_model& model) {
    struct State {
        haptable_model model;
        haptable_room room;
        haptable_output out;
    };
    auto state = std::make_shared<State>();
    state->model = model;
    return {[state](const auto&) { haptable_servo_init(&state->room.fingers.servo[0]); },
            [state](const auto& x) {
                haptable_servo_step(&state->model, &state->room.fingers.servo[0], x.data(), 0, &state->out);
            }};
}

/// Modes without passivity, which no proxy has.
std::vector<Mode> modes_beside() {
    std::vector<Mode> modes = every_mode();
    std::erase_if(modes, [](const Mode& mode) { return mode.more == "passivity"; });
    return modes;
}

/// What is compared on a body: proxies, and modes in the order of modes_beside().
struct ProxyTimes {
    Times finger, shell, shell_friction;
    std::vector<Times> mode;
};

/// All in turn, so that a ratio compares the same minutes.
ProxyTimes times_on(const std::array<std::unique_ptr<Subject>, 3>& subjects, int rounds) {
    const Tables& tables = subjects[0]->tables();
    const std::vector<FingerPath> strokes = slow_strokes(tables);
    const std::vector<char> counts = contact_ticks(subjects[0]->model(), strokes);
    std::vector<Touched> touched{{[](const auto&) {}, [](const auto&) {}},
                                 proxy_on<FingerProxy>(tables),
                                 proxy_on<ShellProxy>(tables, 0.0, 0.0),
                                 proxy_on<ShellProxy>(tables, kStaticFriction, kDynamicFriction)};
    const std::size_t proxies = touched.size();
    for (const Mode& mode : modes_beside())
        touched.push_back(servo_on(in_mode(subjects[static_cast<std::size_t>(mode.force)]->model(), mode)));
    std::vector<std::vector<double>> fastest_s(
        touched.size(), std::vector<double>(counts.size(), std::numeric_limits<double>::infinity()));
    for (int round = 0; round < rounds; ++round)
        for (std::size_t i = 0; i < touched.size(); ++i) time_round(touched[i], strokes, fastest_s[i]);
    const double clock_s = times_of(fastest_s[0], counts, 0.0).median_s;
    const auto of = [&](std::size_t i) { return times_of(fastest_s[i], counts, clock_s); };
    ProxyTimes beside{of(1), of(2), of(3), {}};
    for (std::size_t i = proxies; i < touched.size(); ++i) beside.mode.push_back(of(i));
    return beside;
}

std::array<std::unique_ptr<Subject>, 3> in_every_force(const Scene& scene, double mask_radius_m,
                                                       const std::filesystem::path& build) {
    std::array<std::unique_ptr<Subject>, 3> subjects;
    for (const ForceLaw force : every<ForceLaw>())
        subjects[static_cast<std::size_t>(force)] =
            touched_as(scene, {force, GodObject::kNearest}, mask_radius_m, build);
    return subjects;
}

Number times(double factor) { return number(factor, fmt::format("{:.1f}", factor)); }

std::vector<Cell> taken(const char* name, const Times& cube, const Times& mouse) {
    std::vector<Cell> row{name};
    for (const Times& of : {cube, mouse})
        for (const double s : {of.mean_s, of.median_s, of.most_s}) row.emplace_back(seconds(s));
    return row;
}

std::vector<Cell> faster(const std::string& name, const Times& cube_proxy, const Times& cube, const Times& mouse_proxy,
                         const Times& mouse) {
    std::vector<Cell> row{name};
    for (const auto& [proxy, mode] : {std::pair{cube_proxy, cube}, {mouse_proxy, mouse}})
        for (const double factor :
             {proxy.mean_s / mode.mean_s, proxy.median_s / mode.median_s, proxy.most_s / mode.most_s})
            row.emplace_back(times(factor));
    return row;
}

}  // namespace

std::pair<NumberTable, NumberTable> beside_proxies(const std::filesystem::path& build, int rounds) {
    const ProxyTimes cube = times_on(in_every_force(contact_cube(5, 0.3), 0.012, build), rounds);
    const ProxyTimes mouse = times_on(in_every_force(read_scene("meshes/mouse.toml"), 0.006, build), rounds);
    NumberTable finger{{"", "cube, mean", "median", "99.9 %", "mouse, mean", "median", "99.9 %"}, {}}, shell = finger;
    finger.rows.push_back(taken("a finger proxy takes", cube.finger, mouse.finger));
    shell.rows.push_back(taken("the stand-in takes", cube.shell, mouse.shell));
    shell.rows.push_back(taken("with friction", cube.shell_friction, mouse.shell_friction));
    std::size_t i = 0;
    for (const Mode& mode : modes_beside()) {
        const bool friction = mode.more == "friction";
        finger.rows.push_back(faster(mode.name(), cube.finger, cube.mode[i], mouse.finger, mouse.mode[i]));
        shell.rows.push_back(faster(mode.name(), friction ? cube.shell_friction : cube.shell, cube.mode[i],
                                    friction ? mouse.shell_friction : mouse.shell, mouse.mode[i]));
        ++i;
    }
    return {finger, shell};
}

}  // namespace haptable
