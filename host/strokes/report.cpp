// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/strokes/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "host/link/finger_path.hpp"

namespace haptable {

namespace {

/// "0", or "3 lost, 1 jump"; "-" where nothing was stroked.
std::string cell_of(const Tally& tally) {
    if (tally.strokes == 0) return "-";
    std::string cell;
    for (std::size_t f = 0; f < kFaults; ++f)
        if (tally.faulty[f] > 0)
            cell += fmt::format("{}{} {}", cell.empty() ? "" : ", ", tally.faulty[f], kFaultNames[f]);
    return cell.empty() ? "0" : cell;
}

/// Mesh x mode.
NumberTable body_table(const CampaignResult& result, bool friction) {
    NumberTable table{{"mesh", "nodes", "strokes"}, {}};
    for (const TouchMode& mode : result.modes)
        if (mode.friction == friction)
            table.columns.push_back(fmt::format("{}, {}", word(mode.force), word(mode.god_object)));
    for (const StrokedMeshResult& one : result.results) {
        std::size_t strokes = 0;
        std::vector<Cell> row{one.mesh.name + (one.mesh.filled ? ", filled" : ""), thousands(one.mesh.nodes), ""};
        for (std::size_t m = 0; m < result.modes.size(); ++m) {
            if (result.modes[m].friction != friction) continue;
            strokes += one.tally[m].strokes;
            row.emplace_back(cell_of(one.tally[m]));
        }
        row[2] = count(strokes);
        table.rows.push_back(row);
    }
    return table;
}

/// Mode x fault.
NumberTable mode_table(const CampaignResult& result) {
    NumberTable table{{"force", "god-object", "friction", "strokes"}, {}};
    table.columns.insert(table.columns.end(), kFaultNames.begin(), kFaultNames.end());
    for (std::size_t m = 0; m < result.modes.size(); ++m) {
        const TouchMode& mode = result.modes[m];
        Tally sum;
        for (const StrokedMeshResult& one : result.results) sum.add(one.tally[m]);
        std::vector<Cell> row{word(mode.force), word(mode.god_object), mode.friction ? "yes" : "no",
                              count(sum.strokes)};
        for (std::size_t faulty : sum.faulty) row.emplace_back(count(faulty));
        table.rows.push_back(row);
    }
    return table;
}

/// Without the file's path, which the error begins with.
std::string reason_of(const LeftOut& left_out) {
    const std::size_t colon = left_out.why.find(": "), slash = left_out.why.rfind('/', colon);
    return slash < colon && colon != std::string::npos ? left_out.why.substr(colon + 2) : left_out.why;
}

NumberTable left_out_table(const CampaignResult& result) {
    NumberTable table{{"left out", "why"}, {}};
    for (const LeftOut& left_out : result.left_out) table.rows.push_back({left_out.name, reason_of(left_out)});
    return table;
}

/// "12.3 %", to two digits.
Number share_of(std::size_t part, std::size_t whole) {
    const double share = whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
    return number(share, part == 0 ? "0" : fmt::format("{:.2g} %", 100.0 * share));
}

/// By god-object.
NumberTable design_table(const CampaignResult& result) {
    NumberTable table{{"by design"}, {}};
    std::vector<Tally> sums;
    for (const GodObject god_object : every<GodObject>()) {
        table.columns.emplace_back(word(god_object));
        Tally& sum = sums.emplace_back();
        for (const StrokedMeshResult& one : result.results)
            for (std::size_t m = 0; m < result.modes.size(); ++m)
                if (result.modes[m].god_object == god_object) sum.add(one.tally[m]);
    }
    const auto add = [&](const char* what, const auto& cell) {
        auto& row = table.rows.emplace_back(std::vector<Cell>{what});
        for (const Tally& sum : sums) row.emplace_back(cell(sum));
    };
    const auto add_share = [&](const char* what, std::size_t Tally::*part) {
        add(what, [&](const Tally& sum) { return share_of(sum.*part, sum.strokes); });
    };
    add_share("strokes with a tick in free air, the god-object behind a part", &Tally::behind);
    add_share("and more than 20 such ticks on end", &Tally::long_behind);
    add("motions of a tick through a part that were not felt", [](const Tally& sum) { return count(sum.passed); });
    add_share("strokes that met `max_force`", &Tally::clamped);
    add("limits of walks, slides and searches, in a million ticks in contact", [](const Tally& sum) {
        const double rate =
            1e6 * static_cast<double>(sum.limits) / static_cast<double>(std::max<std::size_t>(1, sum.contact_ticks));
        return number(rate, thousands(static_cast<std::uint64_t>(std::lround(rate))));
    });
    return table;
}

}  // namespace

Numbers numbers_of(const CampaignResult& result) {
    const Tally all = result.total();
    double tables_s = 0.0;
    for (const StrokedMeshResult& one : result.results) tables_s += one.tables_cpu_s;
    const auto minutes = [](double s) { return number(s, fmt::format("{:.1f} minutes", s / 60.0)); };
    const double each_s = 1e5 * all.cpu_s / static_cast<double>(std::max<std::size_t>(1, all.strokes));
    Numbers numbers("make strokes");
    numbers.add("strokes-count", count(all.strokes));
    numbers.add("strokes-ticks", count(all.ticks));
    numbers.add("strokes-contact", count(all.contact_ticks));
    numbers.add("strokes-broken", count(all.broken.size()));
    numbers.add("strokes-bodies", count(result.results.size()));
    numbers.add("strokes-seed", count(result.seed));
    numbers.add("strokes-cpu", minutes(all.cpu_s));
    numbers.add("strokes-cpu-rate", number(each_s, fmt::format("{:.0f} s", each_s)));
    numbers.add("strokes-cpu-tables", minutes(tables_s));
    numbers.add("strokes-modes", mode_table(result));
    numbers.add("strokes-smooth", body_table(result, false));
    numbers.add("strokes-friction", body_table(result, true));
    numbers.add("strokes-left-out", left_out_table(result));
    numbers.add("contact-by-design", design_table(result));
    return numbers;
}

nlohmann::ordered_json to_json(const CampaignResult& result) {
    nlohmann::ordered_json json{{"seed", result.seed},
                                {"taken_over_strokes", result.taken_over},
                                {"total", to_json(result.total())},
                                {"bodies", nlohmann::ordered_json::array()},
                                {"left_out", nlohmann::ordered_json::array()}};
    for (const StrokedMeshResult& one : result.results) {
        nlohmann::ordered_json modes;
        for (std::size_t m = 0; m < result.modes.size(); ++m) modes[result.modes[m].name()] = to_json(one.tally[m]);
        json["bodies"].push_back({{"name", one.mesh.name},
                                  {"nodes", one.mesh.nodes},
                                  {"patches", one.mesh.patches},
                                  {"hinges", one.mesh.hinges},
                                  {"tables_cpu_s", one.tables_cpu_s},
                                  {"modes", modes}});
    }
    for (const LeftOut& left_out : result.left_out)
        json["left_out"].push_back({{"name", left_out.name}, {"why", left_out.why}});
    return json;
}

std::string to_csv(const Stroke& stroke) {
    std::string text = "x,y,z\n";
    for (const auto& x : stroke) text += fmt::format("{:.9g},{:.9g},{:.9g}\n", x[0], x[1], x[2]);
    return text;
}

Stroke read_stroke(const std::filesystem::path& file) {
    Stroke stroke;
    for (const auto& x : read_finger_path(file, Positions::any))
        stroke.push_back({static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2])});
    return stroke;
}

std::string to_csv(const Stroke& stroke, const std::vector<Judged>& ticks) {
    std::string text =
        "tick,x,y,z,contact,inside,sees_god,patch,alpha_0,alpha_1,alpha_2,god_x,god_y,god_z,limits,gap_m,force_n,law_n,"
        "change_n,stored_j,given_j,faults\n";
    for (std::size_t i = 0; i < stroke.size(); ++i) {
        const Judged& t = ticks[i];
        text += fmt::format("{},{:.9g},{:.9g},{:.9g},{:d},{:d},{:d},", i, stroke[i][0], stroke[i][1], stroke[i][2],
                            t.contact, t.inside, t.sees_god);
        text +=
            fmt::format("{},{:.6g},{:.6g},{:.6g},{:.9g},{:.9g},{:.9g},{},", t.contact ? std::to_string(t.at.patch) : "",
                        t.at.alpha[0], t.at.alpha[1], t.at.alpha[2], t.god_m.x(), t.god_m.y(), t.god_m.z(), t.limits);
        text += fmt::format("{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{}\n", t.gap_m, t.force_n, t.law_n, t.change_n,
                            t.stored_j, t.given_j, t.faults);
    }
    return text;
}

}  // namespace haptable
