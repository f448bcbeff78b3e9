// SPDX-License-Identifier: GPL-2.0-or-later
// A program's summary: a table for people, one flat JSON object for scripts.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace haptable {

class SummaryLines {
public:
    using Value = std::variant<std::int64_t, double, std::string>;

    /// Appends a line. The key ends with the unit: latency_mean_us.
    void add(const std::string& key, Value value) { lines_.emplace_back(key, std::move(value)); }

    std::string table() const;
    std::string json() const;
    /// To standard output: as JSON, as a table, or, with `quiet` alone, not at all.
    void print(bool as_json, bool quiet) const;

private:
    std::vector<std::pair<std::string, Value>> lines_;
};

}  // namespace haptable
