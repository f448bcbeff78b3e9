// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/strokes/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "host/base/file.hpp"
#include "host/base/hash.hpp"
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

std::string kind_of(const TouchMode& mode) {
    return std::string(mode.fingers == 2 ? "two" : "one") + (mode.body.free ? ", free" : ", held") +
           (mode.body.rings ? ", rings" : "");
}

/// Mesh x what touches it and how it moves, all forces and god-objects together.
NumberTable body_table(const CampaignResult& result) {
    NumberTable table{{"mesh", "nodes", "strokes"}, {}};
    std::vector<std::string> kinds;
    for (const TouchMode& mode : result.modes)
        if (std::find(kinds.begin(), kinds.end(), kind_of(mode)) == kinds.end()) kinds.push_back(kind_of(mode));
    table.columns.insert(table.columns.end(), kinds.begin(), kinds.end());
    for (const StrokedMeshResult& one : result.results) {
        Tally all;
        std::vector<Cell> row{one.mesh.name + (one.mesh.filled ? ", filled" : ""), thousands(one.mesh.nodes), ""};
        for (const std::string& kind : kinds) {
            Tally sum;
            for (std::size_t m = 0; m < result.modes.size(); ++m)
                if (kind_of(result.modes[m]) == kind) sum.add(one.tally[m]);
            row.emplace_back(cell_of(sum));
            all.add(sum);
        }
        row[2] = count(all.strokes);
        table.rows.push_back(row);
    }
    return table;
}

/// Way of touching x fault; way: what a mode is summed by.
template <typename Way>
NumberTable fault_table(const CampaignResult& result, std::vector<std::string> columns, const Way& way) {
    std::vector<std::pair<std::vector<std::string>, Tally>> sums;
    for (std::size_t m = 0; m < result.modes.size(); ++m) {
        const std::vector<std::string> name = way(result.modes[m]);
        auto at = std::find_if(sums.begin(), sums.end(), [&](const auto& sum) { return sum.first == name; });
        if (at == sums.end()) at = sums.insert(sums.end(), {name, Tally()});
        for (const StrokedMeshResult& one : result.results) at->second.add(one.tally[m]);
    }
    NumberTable table{std::move(columns), {}};
    table.columns.emplace_back("strokes");
    table.columns.insert(table.columns.end(), kFaultNames.begin(), kFaultNames.end());
    for (const auto& [name, sum] : sums) {
        std::vector<Cell> row(name.begin(), name.end());
        row.emplace_back(count(sum.strokes));
        for (const std::size_t faulty : sum.faulty) row.emplace_back(count(faulty));
        table.rows.push_back(row);
    }
    return table;
}

/// By force, god-object and friction.
NumberTable mode_table(const CampaignResult& result) {
    return fault_table(result, {"force", "god-object", "friction"}, [](const TouchMode& mode) {
        return std::vector<std::string>{word(mode.force), word(mode.god_object), mode.friction ? "yes" : "no"};
    });
}

/// By fingers and how the body moves.
NumberTable kind_table(const CampaignResult& result) {
    return fault_table(result, {"fingers and body"},
                       [](const TouchMode& mode) { return std::vector<std::string>{kind_of(mode)}; });
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

namespace {

/// C without comments and white space.
std::string bare(const std::string& c) {
    std::string text;
    for (std::size_t i = 0; i < c.size(); ++i) {
        if (c.compare(i, 2, "/*") == 0)
            i = std::min(c.size(), c.find("*/", i + 2)) + 1;
        else if (c.compare(i, 2, "//") == 0)
            i = std::min(c.size(), c.find('\n', i));
        else if (std::isspace(static_cast<unsigned char>(c[i])) == 0)
            text += c[i];
    }
    return text;
}

}  // namespace

std::string source_identity(const std::filesystem::path& folder) {
    std::set<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.path().extension() == ".c" || entry.path().extension() == ".h") files.insert(entry.path());
    Hash hash;
    for (const std::filesystem::path& file : files) {
        hash.add(file.filename().string());
        hash.add(bare(read_file(file)));
    }
    return hash.text();
}

Numbers numbers_of(const CampaignResult& result, const std::filesystem::path& firmware) {
    const Tally all = result.total();
    double tables_s = 0.0;
    for (const StrokedMeshResult& one : result.results) tables_s += one.tables_cpu_s;
    const auto minutes = [](double s) { return number(s, fmt::format("{:.1f} minutes", s / 60.0)); };
    const double each_s = 1e5 * all.cpu_s / static_cast<double>(std::max<std::size_t>(1, all.strokes));
    Numbers numbers("make strokes");
    if (std::filesystem::exists(firmware)) {
        const std::string identity = source_identity(firmware);
        numbers.add("strokes-firmware",
                    number(static_cast<double>(std::stoul(identity.substr(0, 8), nullptr, 16)), identity));
    }
    numbers.add("strokes-count", count(all.strokes));
    numbers.add("strokes-ticks", count(all.ticks));
    numbers.add("strokes-contact", count(all.contact_ticks));
    numbers.add("strokes-both", count(all.both_ticks));
    numbers.add("strokes-area", number(all.most_area, fmt::format("{:.2g}", all.most_area * 0x1p24)));
    numbers.add("strokes-broken", count(all.broken.size()));
    numbers.add("strokes-bodies", count(result.results.size()));
    numbers.add("strokes-seed", count(result.seed));
    numbers.add("strokes-cpu", minutes(all.cpu_s));
    numbers.add("strokes-cpu-rate", number(each_s, fmt::format("{:.0f} s", each_s)));
    numbers.add("strokes-cpu-tables", minutes(tables_s));
    numbers.add("strokes-modes", mode_table(result));
    numbers.add("strokes-kinds", kind_table(result));
    numbers.add("strokes-meshes", body_table(result));
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

std::string to_csv(const Stroke& stroke, int fingers) {
    std::string text = fingers == 2 ? "x,y,z,x2,y2,z2\n" : "x,y,z\n";
    for (const FingerPositions& x : stroke) {
        text += fmt::format("{:.9g},{:.9g},{:.9g}", x[0][0], x[0][1], x[0][2]);
        if (fingers == 2) text += fmt::format(",{:.9g},{:.9g},{:.9g}", x[1][0], x[1][1], x[1][2]);
        text += "\n";
    }
    return text;
}

Stroke read_stroke(const std::filesystem::path& file) {
    Stroke stroke;
    const auto rounded = [](const std::array<double, 3>& x) {
        return std::array{static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2])};
    };
    for (const FingerTick& tick : read_finger_ticks(file, Positions::any))
        stroke.push_back({rounded(tick.position_m), rounded(tick.second_m.value_or(std::array<double, 3>{}))});
    return stroke;
}

std::string to_csv(const std::vector<Judged>& ticks, int fingers) {
    std::string text =
        "tick,finger,x,y,z,contact,inside,sees_god,patch,alpha_0,alpha_1,alpha_2,god_x,god_y,god_z,limits,gap_m,"
        "force_n,law_n,change_n,stored_j,given_j,faults\n";
    for (std::size_t i = 0; i < ticks.size(); ++i) {
        const Judged& t = ticks[i];
        const auto count = static_cast<std::size_t>(fingers);
        text += fmt::format("{},{},{:.9g},{:.9g},{:.9g},{:d},{:d},{:d},", i / count, i % count, t.at_m.x(), t.at_m.y(),
                            t.at_m.z(), t.contact, t.inside, t.sees_god);
        text +=
            fmt::format("{},{:.6g},{:.6g},{:.6g},{:.9g},{:.9g},{:.9g},{},", t.contact ? std::to_string(t.at.patch) : "",
                        t.at.alpha[0], t.at.alpha[1], t.at.alpha[2], t.god_m.x(), t.god_m.y(), t.god_m.z(), t.limits);
        text += fmt::format("{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{}\n", t.gap_m, t.force_n, t.law_n, t.change_n,
                            t.stored_j, t.given_j, t.faults);
    }
    return text;
}

}  // namespace haptable
