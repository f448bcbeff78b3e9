// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/timings.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/base/error.hpp"

namespace haptable {

void Timings::add(const std::string& row, const std::string& subject, double s) {
    samples_[{row, subject}].push_back(s);
}

double Timings::at(const std::string& row, const std::string& subject) const {
    const auto found = samples_.find({row, subject});
    if (found == samples_.end()) throw Error(fmt::format("the bench did not measure {} of {}", row, subject));
    std::vector<double> samples = found->second;
    const auto middle = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
    std::nth_element(samples.begin(), middle, samples.end());
    return *middle;
}

}  // namespace haptable
