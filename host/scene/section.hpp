// SPDX-License-Identifier: GPL-2.0-or-later
// A table of the scene file, and errors that name its file, line and key.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

// The library's assertions fail on some files ("[#"): an exception reaches the user as an error, an abort does not.
[[noreturn]] inline void fail_toml(const char* what) { throw std::logic_error(what); }
#define TOML_ASSERT(condition) ((condition) ? static_cast<void>(0) : fail_toml(#condition))
#include <toml++/toml.h>

namespace haptable {

using Names = std::vector<std::string_view>;

/// "; did you mean side?", or the list of what there is where nothing is near.
std::string suggest(std::string_view wrong, const Names& known);

/// "a table", "a whole number": what a value is, for errors.
std::string_view type_name(const toml::node& node);

/// One table of the scene file. Every reader throws Error "FILE:LINE: section.key: what is wrong".
class Section {
public:
    Section(const std::filesystem::path& file, std::string name, const toml::table& table)
        : file_(file), name_(std::move(name)), table_(table) {}

    /// Throws for a key that is not among these.
    void require_known(const Names& known) const;

    bool has(std::string_view key) const { return table_.contains(key); }
    const toml::node* find(std::string_view key) const { return table_.get(key); }

    /// Throws at the line of the key, or of its table where the key is missing.
    [[noreturn]] void fail(std::string_view key, const std::string& what) const;

    /// Finite.
    double number(std::string_view key) const;
    std::int64_t integer(std::string_view key) const;
    bool flag(std::string_view key) const;
    std::string text(std::string_view key) const;
    /// The path of a file that the key names, from the scene's own on.
    std::filesystem::path beside(std::string_view key) const { return file_.parent_path() / text(key); }
    /// One of `have`.
    std::string choice(std::string_view key, const Names& have) const;

    /// `count` finite numbers; `example` says of which kind.
    std::vector<double> numbers(std::string_view key, std::size_t count, std::string_view example) const;
    /// Two vectors of three numbers.
    std::array<std::array<double, 3>, 2> two_vectors(std::string_view key, std::string_view example) const;
    std::array<std::string, 2> two_texts(std::string_view key, std::string_view example) const;

    /// The table of that name; an empty one where it is left out.
    Section section(std::string_view key, bool required) const;
    /// All tables [[key]].
    std::vector<Section> sections(std::string_view key) const;

    /// Line of the key, or of the table where it has no such key.
    int line(std::string_view key = {}) const;

private:
    std::string full(std::string_view key) const;
    [[noreturn]] void missing(std::string_view key, std::string_view type) const;

    const std::filesystem::path& file_;
    std::string name_;
    const toml::table& table_;
};

/// What the file says. Throws Error with its line where it is no TOML, or a mesh.
toml::table parse_scene_file(const std::filesystem::path& file);

}  // namespace haptable
