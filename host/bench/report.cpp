// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/report.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/base/error.hpp"

namespace haptable {

void Timings::add(const std::string& row, const std::string& subject, double nanoseconds) {
    samples_[{row, subject}].push_back(nanoseconds);
}

double Timings::at(const std::string& row, const std::string& subject) const {
    const auto found = samples_.find({row, subject});
    if (found == samples_.end()) throw Error(fmt::format("the bench did not measure {} of {}", row, subject));
    std::vector<double> samples = found->second;
    const auto middle = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
    std::nth_element(samples.begin(), middle, samples.end());
    return *middle;
}

std::string duration(double nanoseconds) {
    if (nanoseconds < 1e3) return fmt::format("{:.3g} ns", nanoseconds);
    if (nanoseconds < 1e6) return fmt::format("{:.3g} us", nanoseconds / 1e3);
    return fmt::format("{:.3g} ms", nanoseconds / 1e6);
}

namespace {

std::string section(const std::string& title, const std::vector<std::string>& subjects, const std::string& beside,
                    const std::vector<ReportRow>& rows) {
    if (rows.empty()) return "";
    std::string text = fmt::format("## {}\n\n| | {} | {} |\n|---{}|---|\n", title, fmt::join(subjects, " | "), beside,
                                   fmt::join(std::vector<std::string>(subjects.size(), "|---"), ""));
    for (const ReportRow& row : rows)
        text += fmt::format("| {} | {} | {} |\n", row.what, fmt::join(row.cells, " | "), row.beside);
    return text + "\n";
}

}  // namespace

std::string to_markdown(const Report& report) {
    return section("Speed", report.subjects, "the paper (Pentium Pro, 200 MHz)", report.speed) +
           section("Error", report.subjects, "against", report.error) +
           section("Ratios of this run", {"value"}, "wanted", report.ratio);
}

std::string to_plot_data(const Timings& timings, const std::vector<std::string>& rows,
                         const std::vector<std::string>& subjects) {
    std::string text;
    for (const std::string& row : rows) {
        text += fmt::format("\"{}\"", row);
        for (const std::string& subject : subjects) text += fmt::format(" {:.6g}", timings.at(row, subject) / 1e3);
        text += "\n";
    }
    return text;
}

}  // namespace haptable
