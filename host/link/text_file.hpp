// SPDX-License-Identifier: GPL-2.0-or-later
// A text file that grows line by line: beside its final place until it is whole, or, for what must not be lost, in it.
#pragma once

#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>

#include "host/base/file.hpp"

namespace haptable {

/// Throws Error "OUT: is what OPTION reads" where both names are one file, by whatever way they lead there.
void require_other_file(const std::filesystem::path& out, const std::filesystem::path& in, const std::string& option);

class TextFile {
public:
    /// Opens it beside `path`. Throws Error that names the path.
    explicit TextFile(const std::filesystem::path& path);
    ~TextFile();
    TextFile(const TextFile&) = delete;
    TextFile& operator=(const TextFile&) = delete;

    /// From now on it stands in its final place, with what was added so far and whatever comes: valid up to the last
    /// flush even if the process is killed. Throws Error that names the path.
    void keep();
    /// Appends whole lines; what the disk does not take is an error of finish(), so that a tick never throws here.
    void add(std::string_view lines);
    /// Writes what was added to the disk, whole lines or none of them.
    void flush();
    /// True once the disk has not taken all: what was there before stays whole, and nothing more is written.
    bool failed() const { return error_ != 0; }
    /// On the disk so far.
    long size_bytes() const { return size_bytes_; }
    /// Ends it: the whole file is in its place. Throws Error when the disk did not take all of it.
    void finish();

private:
    std::filesystem::path path_;
    StagedPath beside_;
    std::FILE* file_;
    std::string buffer_;
    bool kept_ = false;
    long size_bytes_ = 0;  ///< on the disk
    int error_ = 0;        ///< errno of the first write that failed
};

}  // namespace haptable
