// SPDX-License-Identifier: GPL-2.0-or-later
// A text of numbers, line by line: no locale, no copies, errors that name the line.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace haptable {

/// Lines end with LF, CRLF or CR. `text` must outlive this object.
class Lines {
public:
    Lines(const std::filesystem::path& file, std::string_view text) : file_(file), rest_(text) {}

    /// Moves to the next line that has a field, comments cut off; false at the end.
    bool next(char comment = '#');
    /// As next(), where the end of the file is an error: "ends before " + what.
    void require(const char* what, char comment = '#');
    /// Stays on this line: the next call of next() gives it again.
    void again() { again_ = true; }

    const std::string& file() const { return name_; }
    std::string_view line() const { return line_; }
    /// Fields of this line, between blanks and commas.
    const std::vector<std::string_view>& fields() const { return field_; }
    std::size_t size() const { return field_.size(); }

    /// Field k as a finite number ("1e400" is none); an error names the line.
    double real(std::size_t k) const;
    /// Field k as a number of a node, an element or a count: not negative.
    std::uint64_t whole(std::size_t k, const char* what) const;
    /// Field k as a count of records of some numbers each: never more than the file can hold.
    std::size_t count(std::size_t k, const char* what) const;

    [[noreturn]] void fail(const std::string& what) const;

private:
    std::string_view field(std::size_t k, const char* what) const;
    void cut();

    std::filesystem::path file_;
    std::string name_ = file_.string();
    std::string_view rest_, line_;
    std::vector<std::string_view> field_;
    std::size_t number_ = 0;
    bool again_ = false;
};

}  // namespace haptable
