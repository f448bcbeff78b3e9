// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/run/plots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>

#include "host/base/child.hpp"
#include "host/base/colors.hpp"
#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/run/recorder.hpp"

namespace haptable {

namespace {

using Points = std::vector<std::array<double, 2>>;

constexpr std::size_t kColumns = 800;  // of a plot, in pixels
constexpr std::chrono::seconds kPlotPatience{60};

struct Curve {
    std::string name;
    Points points;
    bool steps = false;
};

struct Figure {
    std::string name, title, unit;
    std::vector<Curve> curves;
};

using Value = std::function<double(const Tick&)>;

Points over_ticks(const std::vector<Tick>& ticks, const Value& value) {
    Points points;
    points.reserve(ticks.size());
    for (const Tick& tick : ticks) points.push_back({tick.time_s, value(tick)});
    return points;
}

/// A curve of the first finger, and behind it of each other where there are more.
std::vector<Curve> of_each(const Timeline& timeline, const std::string& name, const Value& value) {
    if (timeline.others.empty()) return {{name, over_ticks(timeline.ticks, value)}};
    std::vector<Curve> curves{{name + ", finger 1", over_ticks(timeline.ticks, value)}};
    for (std::size_t i = 0; i < timeline.others.size(); ++i)
        curves.push_back({fmt::format("{}, finger {}", name, i + 2), over_ticks(timeline.others[i], value)});
    return curves;
}

/// Size and components for one finger, the sizes for more.
std::vector<Curve> force_curves(const Timeline& timeline) {
    std::vector<Curve> curves = of_each(timeline, "size", [](const Tick& t) { return t.force_size_n(); });
    constexpr std::array kAxes{"x", "y", "z"};
    for (std::size_t a = 0; timeline.others.empty() && a < 3; ++a)
        curves.push_back({kAxes[a], over_ticks(timeline.ticks, [a](const Tick& t) { return t.force_n[a]; })});
    return curves;
}

std::vector<Curve> energy_curves(const Timeline& timeline) {
    std::vector<Curve> curves =
        of_each(timeline, "stored in the contact", [](const Tick& t) { return 1e3 * t.stored_j; });
    for (Curve& curve : of_each(timeline, "given to the user so far", [](const Tick& t) { return 1e3 * t.given_j; }))
        curves.push_back(std::move(curve));
    return curves;
}

Points over_statuses(const Timeline& timeline, const std::string& counter) {
    Points points;
    for (const StatusPoint& status : timeline.statuses)
        if (const auto found = status.counters.find(counter); found != status.counters.end())
            points.push_back({status.time_s, static_cast<double>(found->second)});
    return points;
}

Points unanswered(const std::vector<Tick>& ticks) {
    double count = 0.0;
    return over_ticks(ticks, [&count](const Tick& tick) { return count += tick.answered ? 0.0 : 1.0; });
}

/// The servo's counters that say that something went wrong, where any did, and the states without an answer.
std::vector<Curve> fault_curves(const Timeline& timeline) {
    std::vector<Curve> curves{{"states without an answer", unanswered(timeline.ticks), true}};
    for (std::size_t i = 0; i < timeline.others.size(); ++i)
        curves.push_back(
            {fmt::format("states of finger {} without an answer", i + 2), unanswered(timeline.others[i]), true});
    if (timeline.statuses.empty()) return curves;
    for (const auto& [name, last] : timeline.statuses.back().counters)
        if (is_fault(name) && last != 0) curves.push_back({name, over_statuses(timeline, name), true});
    return curves;
}

std::vector<Figure> figures(const Timeline& timeline) {
    std::vector<Figure> all;
    all.push_back({"force", "Force on the finger", "N", force_curves(timeline)});
    all.push_back({"depth", "Depth: from the god-object to the finger", "mm",
                   of_each(timeline, "depth", [](const Tick& t) { return 1e3 * t.depth_m; })});
    all.push_back({"energy", "Energy", "mJ", energy_curves(timeline)});
    if (!timeline.simulated)
        all.push_back({"latency", "Latency: from a state to its answer", "us",
                       of_each(timeline, "latency", [](const Tick& t) { return t.latency_us; })});
    all.push_back({"faults", "Faults so far", "count", fault_curves(timeline)});
    return all;
}

/// Names hold letters, digits and underscores, which gnuplot would lower; titles are ours.
std::string script_of(const Figure& figure) {
    std::string script;
    std::string plots;
    for (std::size_t i = 0; i < figure.curves.size(); ++i) {
        const Curve& curve = figure.curves[i];
        script += fmt::format("${}{} << END\n", figure.name, i);
        Points points = thinned(curve.points, kColumns);
        if (points.empty()) points.push_back({0.0, 0.0});
        for (const auto& [time_s, value] : points)
            fmt::format_to(std::back_inserter(script), "{:.6g} {:.6g}\n", time_s, value);
        script += "END\n";
        plots += fmt::format("{}${}{} using 1:2 with {} title \"{}\" noenhanced", plots.empty() ? "" : ", ",
                             figure.name, i, curve.steps ? "steps" : "lines", curve.name);
    }
    return script + fmt::format(
                        "set terminal svg size 900,320 font 'DejaVu Sans,11' name '{}' background 'white'\n"
                        "set output '{}.svg'\nset ylabel '{}' noenhanced\nplot {}\nset output\n",
                        figure.name, figure.name, figure.unit, plots);
}

std::string style() {
    std::string text =
        "set xlabel 's'\nset key below\nset lmargin 10\nset rmargin 3\nset yrange [*:*]\n"
        "set offsets 0, 0, graph 0.05, graph 0.05\n";
    text += fmt::format("set grid lc rgb '{}'\n", css(drawn_color("grid_line")));
    int number = 0;
    for (const Rgb8& color : {drawn_color("first_curve"), drawn_color("second_curve"), drawn_color("third_curve"),
                              drawn_color("fourth_curve")}) {
        ++number;
        text += fmt::format("set linetype {} lw {} lc rgb '{}'\n", number, number == 1 ? 1.5 : 1.0, css(color));
    }
    return text;
}

/// What the servo's state, as in servo_force, looks like behind the curves.
struct Band {
    int servo_state;
    Rgb8 color;
};
constexpr std::array<Band, 4> kBands{{{0, drawn_color("silent")},
                                      {3, drawn_color("rejected")},
                                      {4, drawn_color("limited")},
                                      {5, drawn_color("faulted")}}};

/// Stretches of time in one of these states; those that no eye could part are one.
std::string bands_of(const Timeline& timeline, double end_s) {
    std::string script;
    int object = 0;
    for (const Band& band : kBands) {
        double from_s = -1.0, to_s = -1.0;
        const auto draw = [&] {
            if (from_s < 0.0) return;
            script += fmt::format(
                "set object {} rectangle from {:.6g}, graph 0 to {:.6g}, graph 1 behind fillcolor rgb '{}' fillstyle "
                "solid 0.25 noborder\n",
                ++object, from_s, std::max(to_s, from_s + end_s / kColumns), css(band.color));
        };
        for (const Tick& tick : timeline.ticks) {
            if (tick.servo_state != band.servo_state) continue;
            if (from_s < 0.0 || tick.time_s > to_s + 2.0 * end_s / kColumns) {
                draw();
                from_s = tick.time_s;
            }
            to_s = tick.time_s + 1e-3;
        }
        draw();
    }
    return script;
}

/// What gnuplot puts before the <svg> belongs to a file, not to a page.
std::string svg_alone(const std::string& file) {
    const std::size_t begin = file.find("<svg");
    return begin == std::string::npos ? std::string() : file.substr(begin);
}

}  // namespace

std::vector<std::array<double, 2>> thinned(const std::vector<std::array<double, 2>>& points, std::size_t columns) {
    Points kept;
    const auto is_number = [](const std::array<double, 2>& p) { return std::isfinite(p[0]) && std::isfinite(p[1]); };
    std::copy_if(points.begin(), points.end(), std::back_inserter(kept), is_number);
    if (kept.size() <= 4 * columns) return kept;
    Points thin;
    const auto lower = [](const auto& a, const auto& b) { return a[1] < b[1]; };
    for (std::size_t column = 0; column < columns; ++column) {
        const auto at = [&](std::size_t c) {
            return kept.begin() + static_cast<std::ptrdiff_t>(c * kept.size() / columns);
        };
        auto [least, most] = std::minmax_element(at(column), at(column + 1), lower);
        if (most < least) std::swap(least, most);
        thin.push_back(*least);
        if (most != least) thin.push_back(*most);
    }
    return thin;
}

std::vector<Plot> draw_plots(const Timeline& timeline, const std::filesystem::path& scratch) {
    const std::vector<Figure> all = figures(timeline);
    const double end_s = timeline.ticks.empty() ? 1.0 : std::max(timeline.ticks.back().time_s, 1e-3);
    std::string script = fmt::format("{}set xrange [0:{:.6g}]\n", style(), end_s);
    script += bands_of(timeline, end_s);
    for (const Figure& figure : all) script += script_of(figure);
    write_file(scratch / "plots.gp", script);
    Child gnuplot("gnuplot", {"gnuplot", "plots.gp"}, scratch.string());
    gnuplot.wait(kPlotPatience);
    if (!gnuplot.is_well()) throw Error(gnuplot.how_it_ended() + "; for plots: apt-get install gnuplot-nox");
    std::vector<Plot> plots;
    for (const Figure& figure : all)
        plots.push_back({figure.title, svg_alone(read_file(scratch / (figure.name + ".svg")))});
    return plots;
}

}  // namespace haptable
