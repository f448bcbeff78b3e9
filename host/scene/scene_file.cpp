// SPDX-License-Identifier: GPL-2.0-or-later
// A scene's file as TOML: what the library cannot be given is refused before it is asked.
#include <fmt/format.h>

#include <algorithm>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/text.hpp"
#include "host/scene/section.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

/// Where the comment or text that begins at `at` ends: behind it. A quote that begins no text, for it is in the middle
/// of something or is not closed, ends at once.
std::size_t skip_quoted(std::string_view text, std::size_t at) {
    if (text[at] == '#') return std::min(text.find('\n', at), text.size());
    if (at > 0 && std::string_view("=,[{ \t\r\n").find(text[at - 1]) == std::string_view::npos) return at + 1;
    const std::string three(3, text[at]);
    const bool long_one = text.substr(at, 3) == three;
    const std::string_view end = long_one ? std::string_view(three) : std::string_view(three).substr(2);
    for (std::size_t k = at + end.size(); k < text.size(); ++k) {
        if (text[at] == '"' && text[k] == '\\')
            ++k;
        else if (text.substr(k, end.size()) == end)
            return k + end.size();
        else if (!long_one && text[k] == '\n')
            break;
    }
    return long_one ? text.size() : at + 1;
}

[[noreturn]] void fail_at(const fs::path& file, std::string_view text, std::size_t at, const char* what) {
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    throw Error(fmt::format("{}:{}: {}", file.string(), line, what));
}

/// One beyond ASCII.
bool has_letter(std::string_view text) {
    return std::any_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) >= 0x80; });
}

/// A text of several lines whose line breaks are escaped: the library asks whether what follows is a blank, which it
/// cannot tell of letters beyond ASCII.
bool is_undefined(std::string_view quoted) {
    return quoted.starts_with("\"\"\"") && quoted.find('\\') != std::string_view::npos && has_letter(quoted);
}

/// What TOML does not allow and the library's behaviour is undefined for: control characters anywhere, and letters
/// beyond ASCII outside of texts and comments.
void require_letters(const fs::path& file, std::string_view text) {
    for (std::size_t at = 0; at < text.size(); ++at)
        if ((static_cast<unsigned char>(text[at]) < ' ' &&
             std::string_view("\t\n\r").find(text[at]) == std::string_view::npos) ||
            text[at] == 0x7f)
            fail_at(file, text, at, "a control character; this is not a text file, or a damaged one");
    for (std::size_t at = 0; at < text.size();)
        if (text[at] == '#' || text[at] == '"' || text[at] == '\'') {
            const std::size_t end = skip_quoted(text, at);
            if (is_undefined(text.substr(at, end - at)))
                fail_at(file, text, at,
                        "a text of several lines with backslashes and letters beyond ASCII; write it on one line");
            if (text[at] != '#' && end == at + 1 && has_letter(text.substr(end)))
                fail_at(file, text, at, "a quote in the middle of something, and letters beyond ASCII after it");
            at = end;
        } else if (static_cast<unsigned char>(text[at++]) >= 0x80)
            fail_at(file, text, at,
                    "a character that is not ASCII stands outside of quotes; write keys in letters a to z");
}

/// A mesh file, by how it begins or by its name: what a stranger tries first.
bool is_mesh(const fs::path& file, std::string_view text) {
    const std::string ending = lower(file.extension().string());
    const auto is_one = [&](std::string_view endings, std::string_view beginnings) {
        const auto begins = [&](const std::string& word) { return !word.empty() && text.starts_with(word); };
        const auto begin = split(beginnings, '|'), end = split(endings, ' ');
        return std::any_of(begin.begin(), begin.end(), begins) ||
               std::find(end.begin(), end.end(), ending) != end.end();
    };
#define HAPTABLE_MESH_FORMAT(NAME, TITLE, ENDINGS, BEGINNINGS) is_one(ENDINGS, BEGINNINGS) ||
    return
#include "host/base/mesh_formats.inc"
        false;
}

}  // namespace

toml::table parse_scene_file(const fs::path& file) {
    const std::string text = read_text(file);
    if (is_mesh(file, text))
        throw Error(
            fmt::format("{}: is a mesh, and a scene is asked for: write a file scene.toml with file = \"{}\" in "
                        "its [mesh], a [material] and what holds it; README.md has one under \"Your own mesh\"",
                        file.string(), file.filename().string()));
    require_letters(file, text);
    try {
        return toml::parse(text);
    } catch (const toml::parse_error& error) {
        throw Error(fmt::format("{}:{}: {} (column {}); docs/SCENE.md has every key", file.string(),
                                error.source().begin.line, error.description(), error.source().begin.column));
    } catch (const std::logic_error&) {
        throw Error(file.string() +
                    ": is not TOML: a table's header or a key has no name; docs/SCENE.md has every "
                    "key");
    }
}

}  // namespace haptable
