// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <map>
#include <string>
#include <vector>

namespace haptable {

/// Measured times, by what was measured and on which subject: the median over the repetitions counts.
class Timings {
public:
    void add(const std::string& row, const std::string& subject, double s);
    /// Median, s. Throws Error when the row was not measured.
    double at(const std::string& row, const std::string& subject) const;

private:
    std::map<std::pair<std::string, std::string>, std::vector<double>> samples_;
};

}  // namespace haptable
