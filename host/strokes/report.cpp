// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/strokes/report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/link/finger_path.hpp"

namespace haptable {

nlohmann::ordered_json to_json(const CampaignResult& result) {
    nlohmann::ordered_json json{{"seed", result.seed},
                                {"taken_over_strokes", result.taken_over},
                                {"total", to_json(result.total())},
                                {"modes", nlohmann::ordered_json::array()},
                                {"bodies", nlohmann::ordered_json::array()},
                                {"left_out", nlohmann::ordered_json::array()}};
    for (const TouchMode& mode : result.modes)
        json["modes"].push_back({{"name", mode.name()},
                                 {"force", word(mode.force)},
                                 {"god_object", word(mode.god_object)},
                                 {"friction", mode.friction},
                                 {"fingers", mode.fingers},
                                 {"tool", mode.tool},
                                 {"free", mode.body.motion > 0},
                                 {"rings", mode.body.rings}});
    for (const StrokedMeshResult& one : result.results) {
        nlohmann::ordered_json modes;
        for (std::size_t m = 0; m < result.modes.size(); ++m) modes[result.modes[m].name()] = to_json(one.tally[m]);
        json["bodies"].push_back({{"name", one.mesh.name},
                                  {"filled", one.mesh.filled},
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
    std::string text = fingers == 2 ? "x,y,z,x2,y2,z2\n" : fingers == kToolHand ? "x,y,z,qw,qx,qy,qz\n" : "x,y,z\n";
    for (const FingerPositions& x : stroke) {
        text += fmt::format("{:.9g},{:.9g},{:.9g}", x[0][0], x[0][1], x[0][2]);
        if (fingers == kToolHand) text += fmt::format(",{:.9g}", fmt::join(turn_of(x[1]), ","));
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
    for (const FingerTick& tick : read_finger_ticks(file, Positions::any)) {
        std::array<double, 3> second = tick.others.empty() ? std::array<double, 3>{} : tick.others[0].position_m;
        if (tick.turn)
            for (std::size_t c = 0; c < 3; ++c) second[c] = std::copysign(1.0, (*tick.turn)[0]) * (*tick.turn)[1 + c];
        stroke.push_back({rounded(tick.position_m), rounded(second)});
    }
    return stroke;
}

std::string to_csv(const std::vector<Judged>& ticks, std::size_t contacts) {
    std::string text =
        "tick,finger,x,y,z,contact,inside,sees_god,patch,alpha_0,alpha_1,alpha_2,god_x,god_y,god_z,limits,gap_m,"
        "force_n,law_n,change_n,stored_j,given_j,faults\n";
    for (std::size_t i = 0; i < ticks.size(); ++i) {
        const Judged& t = ticks[i];
        text += fmt::format("{},{},{:.9g},{:.9g},{:.9g},{:d},{:d},{:d},", i / contacts, i % contacts, t.at_m.x(),
                            t.at_m.y(), t.at_m.z(), t.contact, t.inside, t.sees_god);
        text +=
            fmt::format("{},{:.6g},{:.6g},{:.6g},{:.9g},{:.9g},{:.9g},{},", t.contact ? std::to_string(t.at.patch) : "",
                        t.at.alpha[0], t.at.alpha[1], t.at.alpha[2], t.god_m.x(), t.god_m.y(), t.god_m.z(), t.limits);
        text += fmt::format("{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{}\n", t.gap_m, t.force_n, t.law_n, t.change_n,
                            t.stored_j, t.given_j, t.faults);
    }
    return text;
}

}  // namespace haptable
