// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/contact/cost.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>

#include "host/bench/contact/bodies.hpp"

namespace haptable {

namespace {

/// This process's time on its core, s: on a machine that does other work too, a clock on the wall would tell of that.
double cpu_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Time of a step along a circle, s.
double time_of_step(const Subject& subject) {
    constexpr std::size_t kTicks = 1000, kRounds = 10;
    const FingerPath path = subject.circle(0.002, kTicks);
    haptable_servo servo = subject.touched(path);
    haptable_output out{};
    const double begin = cpu_s();
    for (std::size_t i = 0; i < kRounds * kTicks; ++i)
        haptable_servo_step(&subject.model(), &servo, path[i % kTicks].data(), 0, &out);
    return (cpu_s() - begin) / static_cast<double>(kRounds * kTicks);
}

/// Medians; all subjects in turn, so that a ratio compares the same minutes.
std::vector<double> time_steps(const std::vector<std::unique_ptr<Subject>>& subjects, int repetitions) {
    std::vector<std::vector<double>> sample(subjects.size());
    for (int repetition = 0; repetition < repetitions; ++repetition)
        for (std::size_t s = 0; s < subjects.size(); ++s) sample[s].push_back(time_of_step(*subjects[s]));
    std::vector<double> median;
    for (auto& one : sample) {
        std::nth_element(one.begin(), one.begin() + repetitions / 2, one.end());
        median.push_back(one[static_cast<std::size_t>(repetitions / 2)]);
    }
    return median;
}

}  // namespace

NumberTable cost_of_modes(const std::filesystem::path& build, int repetitions) {
    std::vector<std::unique_ptr<Subject>> subjects;
    const Scene mouse = read_scene("meshes/mouse.toml");
    for (const ContactMode& mode : kContactModes) {
        subjects.push_back(touched_as(contact_cube(5, 0.3), mode, 0.012, build));
        subjects.push_back(touched_as(mouse, mode, 0.006, build));
    }
    const std::vector<double> s = time_steps(subjects, repetitions);
    NumberTable table{{"force", "god-object", "time of a step, cube", "mouse", "bytes of tables, cube", "mouse"}, {}};
    for (std::size_t m = 0; m < kContactModes.size(); ++m) {
        std::vector<Cell> row{word(kContactModes[m].force), word(kContactModes[m].god_object)};
        for (std::size_t b : {0U, 1U})
            row.push_back(number(s[2 * m + b] / s[b], fmt::format("{:.2f}", s[2 * m + b] / s[b])));
        for (std::size_t b : {0U, 1U}) row.push_back(count(subjects[2 * m + b]->table_bytes()));
        table.rows.push_back(row);
    }
    return table;
}

}  // namespace haptable
