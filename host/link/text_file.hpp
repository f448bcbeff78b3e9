// SPDX-License-Identifier: GPL-2.0-or-later
// A text file that grows line by line, beside its final place.
#pragma once

#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>

#include "host/base/file.hpp"

namespace haptable {

class TextFile {
public:
    /// Opens it beside `path`. Throws Error that names the path.
    explicit TextFile(const std::filesystem::path& path);
    ~TextFile();
    TextFile(const TextFile&) = delete;
    TextFile& operator=(const TextFile&) = delete;

    /// Appends; what the disk does not take is an error of finish(), so that a tick never throws here.
    void add(std::string_view text);
    /// Puts the whole file in its place. Throws Error when the disk did not take all of it.
    void finish();

private:
    void flush();

    std::filesystem::path path_;
    Beside beside_;
    std::FILE* file_;
    std::string buffer_;
    int error_ = 0;  ///< errno of the first write that failed
};

}  // namespace haptable
