// SPDX-License-Identifier: GPL-2.0-or-later
// Figures of the pages (scripts/figures.sh, scripts/plots.sh, docs/figures): each is drawn of what it is about, and
// refused, without a file, where its input does not show that.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "codegen/in_memory.hpp"
#include "codegen/model.hpp"
#include "host/base/file.hpp"
#include "host/base/json.hpp"
#include "host/servo/replay.hpp"
#include "host/tables/tables.hpp"
#include "tests/loop/helpers.hpp"
#include "tests/process.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;

class Figure : public testing::Test {
protected:
    void SetUp() override {
        if (run("gnuplot --version").status != 0) GTEST_SKIP() << "no gnuplot: sh scripts/setup.sh installs it";
    }

    /// scripts/plot.sh of docs/figures/NAME.gp.
    Outcome draw(const std::string& name, const std::string& definitions) const {
        return run(fmt::format("sh scripts/plot.sh {} {} \"{}\"", name, svg().string(), definitions));
    }
    void expect_drawn(const Outcome& ended) const {
        EXPECT_EQ(ended.status, 0) << ended.err;
        EXPECT_TRUE(fs::exists(svg()));
        fs::remove(svg());
    }
    void expect_refused(const Outcome& ended, const std::string& what) const {
        EXPECT_NE(ended.status, 0);
        EXPECT_NE(ended.err.find("is to show " + what), std::string::npos) << ended.err;
        EXPECT_FALSE(fs::exists(svg()));
        EXPECT_FALSE(fs::exists(svg().string() + ".new"));
    }
    fs::path svg() const { return folder / "figure.svg"; }
    std::string file(const std::string& text) const {
        write_file(folder / "data", text);
        return (folder / "data").string();
    }

    WorkFolder folder;
};

/// The last tick of a path through the cube's top, in words.
std::string last_tick(const fs::path& tables_folder, const std::string& path, const fs::path& folder) {
    const Tables tables = read_tables(tables_folder);
    const ServoModel servo = build_model(tables);
    const haptable_model model = model_in_memory(tables, servo);
    const std::vector<std::uint32_t> nodes(servo.node.begin(), servo.node.end());
    write_file(folder / "path.csv", path);
    replay({&model, nodes.data(), "cube"}, folder / "path.csv", folder / "felt.csv", true);
    std::string line = lines_of(read_file(folder / "felt.csv")).back();
    std::replace(line.begin(), line.end(), ',', ' ');
    return line;
}

// A path that leaps is refused by the servo: what was drawn of it showed no contact.
TEST_F(Figure, ContactShowsGodObjectPatchDisplacementAndForce) {
    const Outcome made = run(fmt::format("{} meshes/cube.toml -o {} --quiet", program("haptable-precompute").string(),
                                         (folder / "cube").string()));
    ASSERT_EQ(made.status, 0) << made.err;
    std::string slow = "x,y,z\n";
    for (int i = 0; i <= 70; ++i)
        slow += fmt::format("{},{},{}\n", 0.013 - 1.2e-3 * i / 70.0, 0.0165 + 7e-4 * i / 70.0, 0.031 - 1e-4 * i);
    const std::string felt = last_tick(folder / "cube", slow, folder.path());
    ASSERT_EQ(draw("contact", "felt='" + felt + "'").status, 0);
    const std::string text = read_file(svg());
    for (const char* label : {"u = x", "F, the force on the finger: 0.", "g, the god-object", "x, the finger"})
        EXPECT_NE(text.find(label), std::string::npos) << label;
    fs::remove(svg());
    const std::string leap = "x,y,z\n0.013,0.0165,0.031\n0.0118,0.0172,0.024\n";
    expect_refused(draw("contact", "felt='" + last_tick(folder / "cube", leap, folder.path()) + "'"), "a contact");
}

/// A servo's CSV of `ticks` rows: columns by their place, counted from 1; others are 0.
std::string table(int ticks, int columns, const std::function<double(int tick, int column)>& value) {
    std::string text;
    for (int tick = -1; tick < ticks; ++tick)
        for (int c = 1; c <= columns; ++c)
            text +=
                (tick < 0 ? fmt::format("c{}", c) : fmt::format("{:.9g}", value(tick, c))) + (c < columns ? "," : "\n");
    return text;
}

TEST_F(Figure, FingersShowsThatOneGivesWayToTheOther) {
    const auto felt = [](bool falls) {
        return table(1600, 40, [falls](int tick, int column) {
            const double press = std::max(0.0, 1.0 - std::abs(tick - 900) / 300.0);
            return column == 1    ? tick
                   : column == 17 ? 0.5 * press
                   : column == 36 ? 0.12 * (falls ? 1.0 - press : 1.0)
                                  : 0.03;
        });
    };
    expect_drawn(draw("fingers", "felt='" + file(felt(true)) + "'"));
    expect_refused(draw("fingers", "felt='" + file(felt(false)) + "'"), "the second force falling");
}

TEST_F(Figure, RelaxationShowsTwoPeaks) {
    const auto felt = [](double left) {
        return table(14300, 20, [left](int tick, int column) {
            const double since = tick < 8600 ? tick - 400 : tick - 10000;
            const bool in = (tick > 300 && tick < 8500) || tick > 9900;
            const double force =
                in ? (tick < 8600 ? 1.0 : 0.85) * (left + (1.0 - left) * std::exp(-std::abs(since) / 1e3)) : 0.0;
            return column == 1 ? tick : column == 17 ? force : column == 5 ? (in ? 1.0 : 0.0) : 0.0;
        });
    };
    expect_drawn(draw("relaxation", "felt='" + file(felt(0.6)) + "'"));
    expect_refused(draw("relaxation", "felt='" + file(felt(1.0)) + "'"), "a force that relaxes");
}

TEST_F(Figure, RelaxationSlidingShowsAnErrorThatRisesAndAPeak) {
    const auto rows = [](double at_10) {
        return fmt::format("0.01 5e-4 5e-4\n0.12 .045 .045\n0.4 .17 .16\n2 .35 .18\n10 .42 {}\n", at_10);
    };
    expect_drawn(draw("relaxation-sliding", "errors='" + file(rows(0.05)) + "'"));
    expect_refused(draw("relaxation-sliding", "errors='" + file(rows(0.4)) + "'"), "a peak after a short press");
}

// haptable-contact's curves.
TEST_F(Figure, CurvesOfContactShowWhatTheyAreAbout) {
    const auto line = [](double last_mask) {
        std::string text;
        for (int i = -70; i <= 70; ++i) {
            text += fmt::format("{}", 0.05 * i);
            for (int m = 0; m < 4; ++m)
                text += fmt::format(" {} {} {}", 40.0 / (1 + m), (60.0 + 15.0 * std::sin(0.2 * i)) / (1 + m),
                                    m < 3 ? 75.0 : last_mask);
            text += "\n";
        }
        return text;
    };
    expect_drawn(draw("contact-line", "data='" + file(line(74.0)) + "'"));
    expect_refused(draw("contact-line", "data='" + file(line(20.0)) + "'"), "a mask that does not change");

    const auto loop = [](double given) {
        std::string text;
        for (int i = 0; i <= 400; ++i) {
            const double leg = i / 100.0, stored = -900.0 * std::sin(M_PI * leg / 4.0);
            text += fmt::format("{}", leg);
            for (int m = 0; m < 6; ++m) text += fmt::format(" {}", stored + (m < 3 ? 300.0 : given) * leg / 4.0);
            text += "\n";
        }
        return text;
    };
    expect_drawn(draw("contact-loop", "data='" + file(loop(-200.0)) + "'"));
    expect_refused(draw("contact-loop", "data='" + file(loop(50.0)) + "'"), "loops of least energy that give none");

    const auto edge = [](double after_n) {
        std::string text;
        for (int t = -40; t <= 240; ++t) {
            const double force = t < 0 ? 0.14 * (t + 40) / 40.0 : t < 160 ? 0.14 - 4e-4 * t : after_n;
            text += fmt::format("{} {} {} {}\n", t, force, force, force);
        }
        return text;
    };
    expect_drawn(draw("contact-edge", "data='" + file(edge(0.0)) + "'"));
    expect_refused(draw("contact-edge", "data='" + file(edge(0.05)) + "'"), "the finger leaving");
}

// Of numbers.json: as it is; then without what each plot is about.
TEST_F(Figure, PlotsOfNumbersShowWhatTheyAreAbout) {
    if (!fs::exists(program("haptable-report"))) GTEST_SKIP() << "no haptable-report: make test makes it";
    const auto plots = [this](const nlohmann::ordered_json& numbers) {
        write_file(folder / "numbers.json", numbers.dump());
        fs::remove_all(folder / "plots");
        fs::create_directory(folder / "plots");
        // No curves of haptable-contact: those have a test of their own.
        fs::create_directory(folder / "build");
        if (!fs::exists(folder / "build/bin"))
            fs::create_symlink(program("haptable-report").parent_path(), folder / "build/bin");
        return run(fmt::format("BUILD={} sh scripts/plots.sh {} {}", (folder / "build").string(),
                               (folder / "numbers.json").string(), (folder / "plots").string()));
    };
    const nlohmann::ordered_json whole = nlohmann::ordered_json::parse(read_file("docs/numbers.json"));
    const Outcome drawn = plots(whole);
    EXPECT_EQ(drawn.status, 0) << drawn.err;
    EXPECT_EQ(drawn.err, "");
    for (const char* name : {"accuracy", "error-time", "error-flash", "error-precompute", "large-strain"})
        EXPECT_TRUE(fs::exists(folder / fmt::format("plots/{}.svg", name))) << name;

    const auto spoilt = [&](const char* topic, const std::function<void(nlohmann::ordered_json & row)>& spoil) {
        nlohmann::ordered_json numbers = whole;
        for (auto& row : numbers.at(topic).at("rows")) spoil(row);
        return plots(numbers);
    };
    Outcome refused = spoilt("points", [](auto& row) {
        if (row.at(3) == "pressure-mask") row.at(6).at("value") = 0.05;
    });
    EXPECT_NE(refused.status, 0);
    EXPECT_NE(refused.err.find("is to show an error of the mask that falls"), std::string::npos) << refused.err;
    EXPECT_FALSE(fs::exists(folder / "plots/error-time.svg"));
    refused = spoilt("speed", [](auto& row) { row.at(1).at("value") = 1e-3; });
    EXPECT_NE(refused.err.find("accuracy: is to show"), std::string::npos) << refused.err;
    refused = spoilt("large-strain-curve", [](auto& row) { row.at(3).at("value") = 1.0; });
    EXPECT_NE(refused.err.find("is to show a force that leaves the linear one"), std::string::npos) << refused.err;
}

// A picture of the viewer is refused where the servo's record has no contact at its tick; the one that is there stays.
TEST_F(Figure, PicturesShowAContact) {
    fs::create_directories(folder / "build/bed");
    fs::create_directories(folder / "build/bin");
    fs::create_directory(folder / "pictures");
    const auto program_of = [this](const char* name, const std::string& text) {
        write_file(folder / name, "#!/bin/sh\n" + text);
        fs::permissions(folder / name, fs::perms::owner_all);
    };
    // What is called with a file behind its last word but one or -o writes that file.
    program_of("build/bin/haptable-view", "for last; do :; done; echo drawn >\"$last\"\n");
    const auto figure = [&](double force_n, int contact) {
        program_of("build/bed/servo",
                   fmt::format("for last; do :; done; printf "
                               "'tick,contact,force_x,force_y,force_z\\n99,1,0,0,1\\n100,{},0,0,{}\\n' >\"$last\"\n",
                               contact, force_n));
        write_file(folder / "pictures/law-bed.png", "before");
        const Outcome ended = run(fmt::format("BUILD={} PICTURES={} sh scripts/figures.sh law-bed",
                                              (folder / "build").string(), (folder / "pictures").string()));
        return std::pair(ended, read_file(folder / "pictures/law-bed.png"));
    };
    const auto [drawn, picture] = figure(0.3, 1);
    EXPECT_EQ(drawn.status, 0) << drawn.err;
    EXPECT_EQ(picture, "drawn\n");
    for (const auto& [force_n, contact] : {std::pair(0.0, 0), std::pair(0.01, 1)}) {
        const auto [refused, stays] = figure(force_n, contact);
        EXPECT_NE(refused.status, 0);
        EXPECT_NE(refused.err.find("at tick 100"), std::string::npos) << refused.err;
        EXPECT_EQ(stays, "before");
    }
    const Outcome unknown = run("sh scripts/figures.sh no-such-figure");
    EXPECT_NE(unknown.status, 0);
    EXPECT_NE(unknown.err.find("no figure no-such-figure"), std::string::npos) << unknown.err;
}

}  // namespace
}  // namespace haptable::test
