// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/run/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/base/child.hpp"
#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/json.hpp"
#include "host/link/messages.hpp"
#include "host/link/statistics.hpp"
#include "host/run/page.hpp"
#include "host/run/timeline.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

class Report {
public:
    Report(const Places& places, const RunOptions& options, const RunOutcome& outcome)
        : places_(places), o_(options), outcome_(outcome) {}

    SummaryLines make(const std::string& scene, const std::string& draw) {
        note_ = outcome_.trouble;
        if (outcome_.interrupted && note_.empty()) note_ = "ended by Ctrl-C";
        Timeline timeline;
        attempt([&] { timeline = read_timeline(o_.folder / "session.lcmlog"); });
        attempt([&] { write_csv(timeline, o_.folder / "session.csv"); });
        if (draw == "pictures" || draw == "film") attempt([&] { draw_body(draw); });
        std::vector<Plot> plots;
        attempt([&] { plots = draw_in_scratch(timeline); });
        SummaryLines summary = summarise(timeline, scene);
        attempt([&] { write_page(scene, plots, summary); });
        attempt([&] { write_file(o_.folder / "summary.json", summary.json()); });
        attempt([&] { keep("servo.json", outcome_.servo_summary); });
        attempt([&] { keep("device.json", outcome_.device_summary); });
        return summary;
    }

private:
    /// One part that fails leaves the others as they are.
    void attempt(const std::function<void()>& part) {
        try {
            part();
        } catch (const Error& error) {
            note_ += (note_.empty() ? "" : "; ") + std::string(error.what());
        }
    }

    /// What a program printed of itself; nothing where it died.
    void keep(const char* name, const std::string& summary) const {
        if (!summary.empty()) write_file(o_.folder / name, summary);
    }

    void draw_body(const std::string& draw) {
        const fs::path out = o_.folder / (draw == "film" ? "session.mp4" : "pictures");
        Child viewer("viewer", {(places_.programs / "haptable-view").string(), places_.scene.string(), "--quiet",
                                "--log", (o_.folder / "session.lcmlog").string(), "--every",
                                std::to_string(o_.every_ms), "-o", out.string()});
        while (!viewer.has_ended() && !(interrupted() && !outcome_.interrupted))
            viewer.wait_some(std::chrono::milliseconds(100));
        viewer.wait(std::chrono::milliseconds(0));
        if (!viewer.is_well()) throw Error(viewer.how_it_ended());
    }

    std::vector<Plot> draw_in_scratch(const Timeline& timeline) const {
        const StagedPath scratch(o_.folder / "plots", StagedKind::folder);
        return draw_plots(timeline, scratch.path());
    }

    /// By the device's summary: where the body is that the finger never met.
    std::string never_met() const {
        const auto device = parse_json_or_discard(outcome_.device_summary);
        return device.is_object() ? device.value("never_met", std::string()) : std::string();
    }

    /// Ticks of one finger that the servo had and the log has not: the logger was kept from its socket until that was
    /// full. None where the servo did not say.
    std::optional<std::int64_t> unrecorded(const Timeline& timeline) const {
        const auto servo = parse_json_or_discard(outcome_.servo_summary);
        if (!servo.is_object() || !servo.contains("ticks") || !timeline.others.empty()) return std::nullopt;
        const auto answered =
            std::count_if(timeline.ticks.begin(), timeline.ticks.end(), [](const Tick& tick) { return tick.answered; });
        return servo["ticks"].get<std::int64_t>() - answered;
    }

    SummaryLines summarise(const Timeline& timeline, const std::string& scene) const {
        SummaryLines summary;
        summary.add("scene", scene);
        summary.add("tables_hash", fmt::format("{:016x}", timeline.tables_hash));
        summary.add("servo_on", o_.target.empty() ? "host" : o_.target);
        summary.add("ticks", static_cast<std::int64_t>(timeline.ticks.size()));
        add_finger(timeline.ticks, kFingerSuffix[0], summary);
        for (std::size_t i = 0; i < timeline.others.size(); ++i) {
            const std::string suffix = kFingerSuffix[i + 1];
            summary.add("ticks" + suffix, static_cast<std::int64_t>(timeline.others[i].size()));
            add_finger(timeline.others[i], suffix, summary);
        }
        if (const std::string where = never_met(); !where.empty()) summary.add("never_met", where);
        summary.add("damaged_messages", timeline.damaged);
        if (const auto ticks = unrecorded(timeline)) summary.add("unrecorded_ticks", *ticks);
        summary.add("wall_s", outcome_.wall_s);
        summary.add("trouble", note_.empty() ? "none" : note_);
        summary.add("report", (o_.folder / "report.html").string());
        return summary;
    }

    /// suffix: of the finger, at the end of each name.
    static void add_finger(const std::vector<Tick>& ticks, const std::string& suffix, SummaryLines& summary) {
        double force_n = 0.0, depth_m = 0.0;
        std::int64_t touching = 0, unanswered = 0;
        DurationStatistics latency;
        for (const Tick& tick : ticks) {
            force_n = std::fmax(force_n, tick.force_size_n());
            depth_m = std::fmax(depth_m, tick.depth_m);
            touching += tick.stored_j > 0.0 ? 1 : 0;
            unanswered += tick.answered ? 0 : 1;
            if (!std::isnan(tick.latency_us)) latency.add(tick.latency_us);
        }
        summary.add("unanswered" + suffix, unanswered);
        summary.add("contact_ticks" + suffix, touching);
        summary.add("largest_force_n" + suffix, force_n);
        summary.add("largest_depth_m" + suffix, depth_m);
        if (latency.count() == 0) return;
        summary.add("latency_mean_us" + suffix, latency.mean_us());
        summary.add("latency_p999_us" + suffix, latency.quantile_us(0.999));
        summary.add("latency_max_us" + suffix, latency.max_us());
    }

    Facts events() const {
        Facts told{"What the programs told", {}};
        for (const ToldEvent& event : outcome_.events)
            told.rows.emplace_back(fmt::format("{:.2f} s", event.time_s), event.text);
        if (outcome_.more_events > 0)
            told.rows.emplace_back("later", fmt::format("{} more lines", outcome_.more_events));
        return told;
    }

    void write_page(const std::string& scene, const std::vector<Plot>& plots, const SummaryLines& summary) const {
        std::vector<Facts> facts{events(), facts_of("Session", summary.json()),
                                 facts_of("Servo", outcome_.servo_summary),
                                 facts_of("Device", outcome_.device_summary)};
        Facts files{"Files beside this page", {}};
        for (const auto& [name, what] : std::initializer_list<std::pair<const char*, const char*>>{
                 {"session.lcmlog", "every message, as lcm-logger writes it"},
                 {"session.csv", "the same as a table, one line a state"},
                 {"servo.csv", "the servo's own record: servo --replay takes it"},
                 {"device.csv", "the device's own record"},
                 {"device_2.csv", "the same of the second hand; device_3.csv of the third, and on"},
                 {"summary.json", "the first table, for scripts; servo.json and device.json are the others"},
                 {"pictures", "the deformed body"},
                 {"session.mp4", "the same as a film"}})
            if (fs::exists(o_.folder / name)) files.rows.emplace_back(name, what);
        facts.push_back(std::move(files));
        write_file(o_.folder / "report.html", report_page("A session with " + scene, note_, plots, facts));
    }

    const Places& places_;
    const RunOptions& o_;
    const RunOutcome& outcome_;
    std::string note_;
};

}  // namespace

SummaryLines report(const Places& places, const RunOptions& options, const std::string& scene,
                    const RunOutcome& outcome, const std::string& draw) {
    return Report(places, options, outcome).make(scene, draw);
}

}  // namespace haptable
