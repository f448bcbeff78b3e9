// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/scene/press_record.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <sstream>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/dense/dense.hpp"

namespace haptable {

namespace {

constexpr std::array<const char*, 3> kColumns{"time_s", "depth_m", "force_n"};
constexpr const char* kHeader = "time_s,depth_m,force_n";
constexpr const char* kHeaderOfSlow = "depth_m,force_n";

[[noreturn]] void fail(const std::filesystem::path& file, std::size_t line, const std::string& what) {
    throw Error(fmt::format("{}:{}: {}", file.string(), line, what));
}

/// Numbers of a line with commas between them, from that column on.
std::array<double, 3> numbers_of(const std::filesystem::path& file, std::size_t line, const std::string& text,
                                 std::size_t first) {
    std::array<double, 3> value{};
    const char *at = text.data(), *const end = at + text.size();
    for (std::size_t i = first; i < 3; ++i) {
        if (i > first && (at == end || *at++ != ','))
            fail(file, line, std::string("must be ") + (first == 0 ? kHeader : kHeaderOfSlow));
        const auto [stop, error] = std::from_chars(at, end, value[i]);
        if (error != std::errc() || !std::isfinite(value[i]))
            fail(file, line, fmt::format("{} holds what is no number", kColumns[i]));
        at = stop;
    }
    if (at != end) fail(file, line, fmt::format("has more than {} numbers", first == 0 ? "three" : "two"));
    return value;
}

/// Up to the first sample without force after the largest.
void cut(ForceRecord& record) {
    const auto largest = std::max_element(record.force_n.begin(), record.force_n.end());
    const auto end = std::find_if(largest, record.force_n.end(), [](double force_n) { return force_n <= 0.0; });
    const auto samples = static_cast<std::size_t>(end - record.force_n.begin());
    for (std::vector<double>* column : {&record.time_s, &record.depth_m, &record.force_n})
        column->resize(std::min(column->size(), samples));
}

}  // namespace

ForceRecord read_force_record(const std::filesystem::path& file) {
    std::istringstream text(read_file(file));
    ForceRecord record;
    std::string line;
    std::size_t first = kColumns.size();  // until there is a header
    for (std::size_t number = 1; std::getline(text, line); ++number) {
        if (!line.empty() && line.back() == '\r') line.pop_back();
        if (line.empty() || line.front() == '#') continue;
        if (first == kColumns.size()) {
            if (line != kHeader && line != kHeaderOfSlow)
                fail(file, number, fmt::format("the header must be {} or {}", kHeader, kHeaderOfSlow));
            first = line == kHeader ? 0 : 1;
            continue;
        }
        const auto [time_s, depth_m, force_n] = numbers_of(file, number, line, first);
        if (!record.time_s.empty() && time_s <= record.time_s.back()) fail(file, number, "its time does not ascend");
        if (first == 0) record.time_s.push_back(time_s);
        record.depth_m.push_back(depth_m);
        record.force_n.push_back(force_n);
    }
    if (record.force_n.empty() || *std::max_element(record.force_n.begin(), record.force_n.end()) <= 0.0)
        fail(file, 1, "holds no force above 0: the force is that of the body against the press");
    if (*std::max_element(record.depth_m.begin(), record.depth_m.end()) <= 0.0)
        fail(file, 1, "holds no depth above 0: the depth is how far the body is pressed in, in metres");
    cut(record);
    return record;
}

DentFit fit_dent(const ForceRecord& record) {
    constexpr Eigen::Index kFewest = 4, kMost = 4;
    const auto count = std::ssize(record.depth_m);
    DentFit fit;
    fit.depth_m = *std::max_element(record.depth_m.begin(), record.depth_m.end());
    fit.largest_n = *std::max_element(record.force_n.begin(), record.force_n.end());
    if (count < kFewest || !(fit.depth_m > 0.0))
        throw Error(fmt::format("the record has {} samples of a press, and a curve needs {}", count, kFewest));
    const Eigen::Map<const Eigen::VectorXd> depth_m(record.depth_m.data(), count),
        force_n(record.force_n.data(), count);
    const Eigen::ArrayXd s = depth_m.array() / fit.depth_m;
    for (Eigen::Index terms = std::min(kMost, count / 2); terms > 0; --terms) {
        Eigen::MatrixXd a(count, terms);
        for (Eigen::Index k = 0; k < terms; ++k) a.col(k) = depth_m.array() * s.pow(static_cast<double>(k));
        const Eigen::VectorXd c = least_squares(a, force_n);
        fit.stiffness_n_per_m = c[0];
        if (!(c[0] > 0.0)) continue;
        fit.misfit_n = (a * c - force_n).norm() / std::sqrt(static_cast<double>(count));
        fit.curve = {{}, 0.5 * c[0] * fit.depth_m * fit.depth_m};
        for (Eigen::Index k = 1; k < terms; ++k) fit.curve.c[static_cast<std::size_t>(k - 1)] = c[k] / c[0];
        if (fit.curve.grows()) return fit;
    }
    throw Error("the record's force does not grow with its depth: is its sign that of the body against the press?");
}

}  // namespace haptable
