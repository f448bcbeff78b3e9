// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/device/faults.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>

#include "host/base/command_line.hpp"

namespace haptable {

namespace {

constexpr double kSpell_s = 0.05, kJump_m = 0.025;

/// One name of the list, and what stands behind it: a share, a time, or both.
struct Part {
    const char* name;
    double FaultPlan::*share;  ///< or null
    double FaultPlan::*time_s;
    Spell FaultPlan::*spell;
    double usual_size;
    bool is_length;
};

constexpr std::array<Part, 11> kParts{{
    {"drop", &FaultPlan::drop, nullptr, nullptr, 0.0, false},
    {"double", &FaultPlan::twice, nullptr, nullptr, 0.0, false},
    {"reorder", &FaultPlan::reorder, nullptr, nullptr, 0.0, false},
    {"corrupt", &FaultPlan::corrupt, nullptr, nullptr, 0.0, false},
    {"delay", nullptr, &FaultPlan::delay_s, nullptr, 0.0, false},
    {"jitter", nullptr, &FaultPlan::jitter_s, nullptr, 0.0, false},
    {"gone", nullptr, nullptr, &FaultPlan::gone, kSpell_s, false},
    {"stuck", nullptr, nullptr, &FaultPlan::stuck, kSpell_s, false},
    {"jump", nullptr, nullptr, &FaultPlan::jump, kJump_m, true},
    {"nan", &FaultPlan::nan, nullptr, nullptr, 0.0, false},
    {"clock-back", nullptr, nullptr, &FaultPlan::clock_back, kSpell_s, false},
}};

std::string names() {
    std::string all;
    for (const Part& part : kParts) all += (all.empty() ? "" : ", ") + std::string(part.name);
    return all;
}

[[noreturn]] void fail(std::string_view part, const std::string& why) {
    throw BadCommandLine(fmt::format("--fault: \"{}\": {}", part, why));
}

/// A number and what follows it; false where there is no number.
bool split(std::string_view text, double& number, std::string_view& unit) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || !std::isfinite(number)) return false;
    unit = text.substr(static_cast<std::size_t>(end - text.data()));
    return true;
}

double share_of(std::string_view part, std::string_view text) {
    double share = 0.0;
    std::string_view unit;
    if (!split(text, share, unit) || !unit.empty() || share < 0.0 || share > 1.0)
        fail(part, "give a share from 0 to 1, as in 0.01");
    return share;
}

double size_of(std::string_view part, std::string_view text, bool is_length) {
    struct Unit {
        std::string_view name;
        double factor;
    };
    constexpr std::array<Unit, 3> kTimes{{{"s", 1.0}, {"ms", 1e-3}, {"us", 1e-6}}};
    constexpr std::array<Unit, 3> kLengths{{{"m", 1.0}, {"mm", 1e-3}, {"um", 1e-6}}};
    double number = 0.0;
    std::string_view unit;
    if (split(text, number, unit) && number >= 0.0)
        for (const Unit& known : is_length ? kLengths : kTimes)
            if (unit == known.name) return number * known.factor;
    fail(part, is_length ? "give a length with m, mm or um, as in 25mm" : "give a time with s, ms or us, as in 20ms");
}

void read_part(std::string_view text, FaultPlan& plan) {
    const std::size_t equals = text.find('=');
    const std::string_view name = text.substr(0, equals);
    for (const Part& part : kParts) {
        if (name != part.name) continue;
        if (equals == std::string_view::npos) fail(text, "give what it is, as in drop=0.01 or delay=20ms");
        const std::string_view value = text.substr(equals + 1);
        if (part.share != nullptr) plan.*part.share = share_of(text, value);
        if (part.time_s != nullptr) plan.*part.time_s = size_of(text, value, false);
        if (part.spell == nullptr) return;
        const std::size_t colon = value.find(':');
        plan.*part.spell = {share_of(text, value.substr(0, colon)), part.usual_size};
        if (colon != std::string_view::npos)
            (plan.*part.spell).size = size_of(text, value.substr(colon + 1), part.is_length);
        return;
    }
    fail(text, "there is no such fault: there are " + names());
}

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace

bool FaultPlan::any() const { return !to_text(*this).empty(); }

FaultPlan parse_faults(const std::string& text) {
    FaultPlan plan;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t comma = std::min(text.find(',', begin), text.size());
        read_part(std::string_view(text).substr(begin, comma - begin), plan);
        begin = comma + 1;
    }
    return plan;
}

FaultPlan random_faults(std::uint64_t seed) {
    Dice dice(seed);
    FaultPlan plan;
    for (const Part& part : kParts) {
        const bool is_there = dice.hits(0.5);
        // Evenly by orders of magnitude: what happens once a minute meets other states than what happens all the time.
        const double often = std::pow(10.0, -4.0 + 3.0 * dice.uniform()), size = dice.uniform();
        if (!is_there) continue;
        if (part.share != nullptr) plan.*part.share = often;
        if (part.time_s != nullptr) plan.*part.time_s = 0.03 * size;
        if (part.spell != nullptr) plan.*part.spell = {0.1 * often, 4.0 * part.usual_size * size};
    }
    return plan;
}

std::string to_text(const FaultPlan& plan) {
    std::string text;
    const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : ",") + part; };
    for (const Part& part : kParts) {
        if (part.share != nullptr && plan.*part.share > 0.0) add(fmt::format("{}={}", part.name, plan.*part.share));
        if (part.time_s != nullptr && plan.*part.time_s > 0.0) add(fmt::format("{}={}s", part.name, plan.*part.time_s));
        if (part.spell != nullptr && (plan.*part.spell).share > 0.0)
            add(fmt::format("{}={}:{}{}", part.name, (plan.*part.spell).share, (plan.*part.spell).size,
                            part.is_length ? "m" : "s"));
    }
    return text;
}

Eigen::Vector3d DeviceFaults::see(const Eigen::Vector3d& position_m, Clock::time_point now) {
    if (now >= stuck_until_ && dice_.hits(plan_.stuck.share)) {
        stuck_at_m_ = position_m;
        stuck_until_ = now + in_seconds(plan_.stuck.size);
    }
    Eigen::Vector3d seen_m = now < stuck_until_ ? stuck_at_m_ : position_m;
    if (dice_.hits(plan_.jump.share)) {
        const double x = dice_.uniform() - 0.5, y = dice_.uniform() - 0.5, z = dice_.uniform() - 0.5;
        const Eigen::Vector3d way(x, y, z);
        if (way.norm() > 0.0) seen_m += plan_.jump.size * way.normalized();
    }
    if (dice_.hits(plan_.nan)) seen_m[static_cast<Eigen::Index>(dice_.below(3))] = kNaN;
    return seen_m;
}

bool DeviceFaults::is_gone(Clock::time_point now) {
    if (now >= gone_until_ && dice_.hits(plan_.gone.share)) gone_until_ = now + in_seconds(plan_.gone.size);
    return now < gone_until_;
}

std::int64_t DeviceFaults::clock(std::int64_t utime) {
    if (dice_.hits(plan_.clock_back.share)) back_us_ += std::llround(1e6 * plan_.clock_back.size);
    return utime - back_us_;
}

}  // namespace haptable
