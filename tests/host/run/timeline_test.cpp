// SPDX-License-Identifier: GPL-2.0-or-later
// The table that is made of a log: rows, answers, depth and energies; a log that was cut off.
#include "host/run/timeline.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host/run/plots.hpp"
#include "tests/loop/recorded_loop.hpp"

namespace haptable::test {
namespace {

class Timelines : public RecordedLoop {
protected:
    /// A poke in lockstep, recorded.
    void record() {
        SessionOptions options;
        options.lockstep = true;
        run(box.scene(), "a", {scripted_path("poke", PathOptions{})}, options);
    }

    SoftBox box;
    std::filesystem::path file = log("a");
};

// The energies are those that the servo accounts, of the floats that it had: theirs to 2^-24 of each of the sums'
// terms.
TEST_F(Timelines, HasEveryTickWithItsAnswerAndTheEnergies) {
    record();
    const ReplayReport report = replay(box.scene(), file, "", true);
    const Timeline timeline = read_timeline(file);
    ASSERT_EQ(timeline.ticks.size(), std::size_t(report.counters.ticks));
    EXPECT_TRUE(timeline.simulated);
    EXPECT_EQ(timeline.tables_hash, SoftBox::kHash);
    EXPECT_EQ(timeline.damaged, 0);
    std::int64_t touching = 0;
    double force_n = 0.0, stored_j = 0.0, given_j = 0.0, moved_j = 0.0;
    for (std::size_t i = 0; i < timeline.ticks.size(); ++i) {
        const Tick &tick = timeline.ticks[i], &before = timeline.ticks[i > 0 ? i - 1 : 0];
        ASSERT_TRUE(tick.answered) << i;
        EXPECT_DOUBLE_EQ(tick.time_s, 1e-3 * double(i));
        touching += tick.servo_state == servo_force::CONTACT ? 1 : 0;
        force_n = std::max(force_n, tick.force_size_n());
        EXPECT_TRUE(tick.depth_m > 0.0 || tick.force_size_n() <= 0.0) << i;
        EXPECT_TRUE(tick.depth_m <= 0.0 || tick.servo_state == servo_force::CONTACT) << i;
        stored_j = std::max(stored_j, tick.stored_j);
        given_j = std::max(given_j, tick.given_j);
        for (std::size_t a = 0; a < 3; ++a)
            moved_j += std::abs(before.force_n[a]) * (std::abs(tick.finger_m[a]) + std::abs(before.finger_m[a]));
    }
    EXPECT_EQ(touching, std::int64_t{report.counters.contact_ticks});
    EXPECT_EQ(force_n, report.largest_force_n);
    EXPECT_GT(stored_j, 0.0);
    EXPECT_NEAR(stored_j, report.energy.most_stored_j(), std::ldexp(moved_j, -24));
    EXPECT_NEAR(given_j, report.energy.most_given_j(), std::ldexp(moved_j, -24));
    ASSERT_EQ(timeline.statuses.size(), 1U);
    EXPECT_EQ(timeline.statuses.front().counters.at("ticks"), std::int64_t{report.counters.ticks});
}

TEST_F(Timelines, IsWrittenAsATableUpToWhereItsLogWasCutOff) {
    record();
    const std::size_t whole = read_timeline(file).ticks.size();
    std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
    const Timeline timeline = read_timeline(file);
    EXPECT_GT(timeline.ticks.size(), whole / 3);
    EXPECT_LT(timeline.ticks.size(), whole);
    EXPECT_LE(timeline.damaged, 1);
    write_csv(timeline, folder / "session.csv");
    const auto lines = lines_of(read_file(folder / "session.csv"));
    ASSERT_EQ(lines.size(), timeline.ticks.size() + 1);
    const auto columns = std::count(lines[0].begin(), lines[0].end(), ',');
    for (const std::string& line : lines) EXPECT_EQ(std::count(line.begin(), line.end(), ','), columns);
}

// However long a session is, a plot keeps its peaks.
TEST(Plots, ThinningKeepsThePeaks) {
    std::vector<std::array<double, 2>> points;
    for (int i = 0; i < 100'000; ++i) points.push_back({1e-3 * i, i == 77'777 ? 8.5 : i == 12'345 ? -3.0 : 0.1});
    points[500][1] = std::nan("");
    const auto thin = thinned(points, 800);
    EXPECT_LE(thin.size(), 1600U);
    EXPECT_TRUE(std::is_sorted(thin.begin(), thin.end(), [](const auto& a, const auto& b) { return a[0] < b[0]; }));
    const auto [least, most] =
        std::minmax_element(thin.begin(), thin.end(), [](const auto& a, const auto& b) { return a[1] < b[1]; });
    EXPECT_EQ((*least)[1], -3.0);
    EXPECT_EQ((*most)[1], 8.5);
}

}  // namespace
}  // namespace haptable::test
