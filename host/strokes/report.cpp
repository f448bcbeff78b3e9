// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/strokes/report.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/link/finger_path.hpp"

namespace haptable {

namespace {

/// "0", or "3 lost, 1 jump".
std::string cell_of(const Tally& tally) {
    std::string cell;
    for (std::size_t f = 0; f < kFaults; ++f)
        if (tally.faulty[f] > 0)
            cell += fmt::format("{}{} {}", cell.empty() ? "" : ", ", tally.faulty[f], kFaultNames[f]);
    return cell.empty() ? "0" : cell;
}

/// Mesh x mode.
NumberTable body_table(const CampaignResult& result, bool friction) {
    NumberTable table{{"mesh", "strokes"}, {}};
    for (const TouchMode& mode : result.modes)
        if (mode.friction == friction)
            table.columns.push_back(fmt::format("{}, {}", word(mode.force), word(mode.god_object)));
    for (const SpecimenResult& one : result.results) {
        std::size_t strokes = 0;
        std::vector<Cell> row{one.specimen.name, ""};
        for (std::size_t m = 0; m < result.modes.size(); ++m) {
            if (result.modes[m].friction != friction) continue;
            strokes += one.tally[m].strokes;
            row.emplace_back(cell_of(one.tally[m]));
        }
        row[1] = count(strokes);
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
        for (const SpecimenResult& one : result.results) sum.add(one.tally[m]);
        std::vector<Cell> row{word(mode.force), word(mode.god_object), mode.friction ? "yes" : "no",
                              count(sum.strokes)};
        for (std::size_t faulty : sum.faulty) row.emplace_back(count(faulty));
        table.rows.push_back(row);
    }
    return table;
}

nlohmann::ordered_json to_json(const Tally& tally) {
    nlohmann::ordered_json faults;
    for (std::size_t f = 0; f < kFaults; ++f) faults[std::string(kFaultNames[f])] = tally.faulty[f];
    return {{"strokes", tally.strokes},
            {"ticks", tally.ticks},
            {"contact_ticks", tally.contact_ticks},
            {"clamped_strokes", tally.clamped},
            {"limits", tally.limits},
            {"most_given", tally.most_given},
            {"broken_strokes", tally.broken.size()},
            {"faults", faults}};
}

}  // namespace

Tally CampaignResult::total() const {
    Tally sum;
    for (const SpecimenResult& one : results)
        for (const Tally& tally : one.tally) sum.add(tally);
    return sum;
}

Numbers numbers_of(const CampaignResult& result) {
    const Tally all = result.total();
    Numbers numbers("make strokes");
    numbers.add("strokes-count", count(all.strokes));
    numbers.add("strokes-ticks", count(all.ticks));
    numbers.add("strokes-contact", count(all.contact_ticks));
    numbers.add("strokes-broken", count(all.broken.size()));
    numbers.add("strokes-bodies", count(result.results.size()));
    numbers.add("strokes-seed", count(result.seed));
    numbers.add("strokes-cpu", number(result.cpu_s, fmt::format("{:.0f} minutes", result.cpu_s / 60.0)));
    numbers.add("strokes-modes", mode_table(result));
    numbers.add("strokes-smooth", body_table(result, false));
    numbers.add("strokes-friction", body_table(result, true));
    return numbers;
}

nlohmann::ordered_json to_json(const CampaignResult& result) {
    nlohmann::ordered_json json{{"seed", result.seed},
                                {"wall_s", result.wall_s},
                                {"cpu_s", result.cpu_s},
                                {"threads", result.threads},
                                {"total", to_json(result.total())},
                                {"bodies", nlohmann::ordered_json::array()},
                                {"refused", nlohmann::ordered_json::array()}};
    for (const SpecimenResult& one : result.results) {
        nlohmann::ordered_json modes;
        for (std::size_t m = 0; m < result.modes.size(); ++m) modes[result.modes[m].name()] = to_json(one.tally[m]);
        json["bodies"].push_back({{"name", one.specimen.name},
                                  {"nodes", one.specimen.nodes},
                                  {"patches", one.specimen.patches},
                                  {"hinges", one.specimen.hinges},
                                  {"modes", modes}});
    }
    for (const Refused& refused : result.refused)
        json["refused"].push_back({{"name", refused.name}, {"why", refused.why}});
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
