// SPDX-License-Identifier: GPL-2.0-or-later
// Measured numbers on their way to the pages: a program that measures writes them as JSON; lab/numbers.py collects them
// in docs/numbers.json and puts them between the markers of the pages. So each number has one owner.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <variant>
#include <vector>

namespace haptable {

/// As pages quote it. `value`: in SI units, or a count; several where one cell tells several (median, worst).
struct Number {
    std::vector<double> value;
    std::string text;  ///< rounded, with its unit
};

Number number(double value, std::string text);
Number seconds(double s);          ///< "0.25 us", "12.1 ms": three digits
Number count(std::uint64_t n);     ///< "9,275"
Number error_of(double relative);  ///< "1.5e-07"

using Cell = std::variant<std::string, Number>;

/// A table as a page shows it; every row has as many cells as there are columns.
struct NumberTable {
    std::vector<std::string> columns;
    std::vector<std::vector<Cell>> rows;
};

/// What one run of a program measured, by topic: the name of a marker.
class Numbers {
public:
    /// `command`: what makes these numbers again.
    explicit Numbers(std::string command);
    ~Numbers();
    Numbers(Numbers&&) noexcept;
    Numbers& operator=(Numbers&&) noexcept;

    void add(const std::string& topic, const Number& number);
    /// Throws Error where a row has other cells than the table has columns.
    void add(const std::string& topic, const NumberTable& table);
    const nlohmann::ordered_json& json() const { return *topics_; }
    void write(const std::filesystem::path& file) const;

private:
    std::string command_;
    std::unique_ptr<nlohmann::ordered_json> topics_;
};

/// As JSON with one row of a table a line, topics in order of their names: a change is seen in a diff.
std::string to_text(const nlohmann::ordered_json& topics);

/// The numbers of `file`. Throws Error that names the file and what is wrong with it.
nlohmann::ordered_json read_numbers(const std::filesystem::path& file);

/// A topic as a person reads it: a table in Markdown, or the text of a number.
std::string to_markdown(const nlohmann::ordered_json& topic);

/// Every topic on standard output, "name: " and then as a person reads it.
void print_topics(const Numbers& numbers);

/// "9,275", for tables.
std::string thousands(std::uint64_t n);

}  // namespace haptable
