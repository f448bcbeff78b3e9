// SPDX-License-Identifier: GPL-2.0-or-later
// What the bench found, as a table for people, a page for the docs, and data for a plot.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace haptable {

/// Measured times, by row and column of the report: median over the repetitions.
class Timings {
public:
    void add(const std::string& row, const std::string& subject, double nanoseconds);
    /// Median, ns. Throws Error when the row was not measured.
    double at(const std::string& row, const std::string& subject) const;

private:
    std::map<std::pair<std::string, std::string>, std::vector<double>> samples_;
};

/// One line of the report.
struct ReportRow {
    std::string what;
    std::vector<std::string> cells;  ///< one a subject
    std::string beside;              ///< the paper's number, or a limit and whether it is kept
};

struct Report {
    std::vector<std::string> subjects;
    std::vector<ReportRow> speed;
    std::vector<ReportRow> error;
    std::vector<ReportRow> ratio;
};

/// "0.25 us", "12.1 ms": three digits.
std::string duration(double nanoseconds);

std::string to_markdown(const Report& report);

/// Rows of a plot: a label in quotes, then microseconds, one column a subject.
std::string to_plot_data(const Timings& timings, const std::vector<std::string>& rows,
                         const std::vector<std::string>& subjects);

}  // namespace haptable
