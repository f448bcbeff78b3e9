// SPDX-License-Identifier: GPL-2.0-or-later
// Names on their way through a shell.
#pragma once

#include <filesystem>
#include <string>

namespace haptable {

/// One word of a shell's command line, whatever it holds: in single quotes.
inline std::string shell_quoted(const std::string& text) {
    std::string quoted = "'";
    for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return quoted + "'";
}

inline std::string shell_quoted(const std::filesystem::path& path) { return shell_quoted(path.string()); }

/// A file's name that no program takes for an option: "-x" is "./-x".
inline std::filesystem::path no_option(const std::filesystem::path& path) {
    return path.string().starts_with('-') ? "." / path : path;
}

}  // namespace haptable
