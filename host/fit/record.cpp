// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/fit/record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>

#include "host/base/error.hpp"
#include "host/base/file.hpp"

namespace haptable {

namespace {

constexpr const char* kHeader = "time_s,depth_m,force_n";

[[noreturn]] void fail(const std::filesystem::path& file, std::size_t line, const std::string& what) {
    throw Error(fmt::format("{}:{}: {}", file.string(), line, what));
}

/// Three numbers with commas between them.
std::array<double, 3> numbers_of(const std::filesystem::path& file, std::size_t line, const std::string& text) {
    std::array<double, 3> value{};
    const char *at = text.data(), *const end = at + text.size();
    for (std::size_t i = 0; i < 3; ++i) {
        if (i > 0 && (at == end || *at++ != ',')) fail(file, line, std::string("must be ") + kHeader);
        const auto [stop, error] = std::from_chars(at, end, value[i]);
        if (error != std::errc() || !std::isfinite(value[i])) fail(file, line, "holds what is no number");
        at = stop;
    }
    if (at != end) fail(file, line, "has more than three numbers");
    return value;
}

/// Up to the first sample without force after the largest.
void cut(ForceRecord& record) {
    const auto largest = std::max_element(record.force_n.begin(), record.force_n.end());
    const auto end = std::find_if(largest, record.force_n.end(), [](double force_n) { return force_n <= 0.0; });
    const auto samples = static_cast<std::size_t>(end - record.force_n.begin());
    for (std::vector<double>* column : {&record.time_s, &record.depth_m, &record.force_n}) column->resize(samples);
}

}  // namespace

ForceRecord read_force_record(const std::filesystem::path& file) {
    std::istringstream text(read_file(file));
    ForceRecord record;
    std::string line;
    for (std::size_t number = 1; std::getline(text, line); ++number) {
        if (!line.empty() && line.back() == '\r') line.pop_back();
        if (number == 1 && line != kHeader) fail(file, 1, std::string("the header must be ") + kHeader);
        if (number == 1 || line.empty()) continue;
        const auto [time_s, depth_m, force_n] = numbers_of(file, number, line);
        if (!record.time_s.empty() && time_s <= record.time_s.back()) fail(file, number, "its time does not ascend");
        record.time_s.push_back(time_s);
        record.depth_m.push_back(depth_m);
        record.force_n.push_back(force_n);
    }
    if (record.time_s.empty() || *std::max_element(record.force_n.begin(), record.force_n.end()) <= 0.0)
        fail(file, 1, "holds no force above 0: the force is that of the body against the press");
    if (*std::max_element(record.depth_m.begin(), record.depth_m.end()) <= 0.0)
        fail(file, 1, "holds no depth above 0: the depth is how far the body is pressed in, in metres");
    cut(record);
    return record;
}

}  // namespace haptable
