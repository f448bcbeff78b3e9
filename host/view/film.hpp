// SPDX-License-Identifier: GPL-2.0-or-later
// A film, made by ffmpeg from the raw pictures.
#pragma once

#include <sys/types.h>

#include <cstdio>
#include <filesystem>
#include <memory>

#include "host/base/file.hpp"
#include "host/view/image.hpp"

namespace haptable {

/// True for the suffixes that Film knows: .mp4 and .gif.
bool is_film(const std::filesystem::path& path);

/// ffmpeg, running, with a pipe to it. The film comes into its place by close(); without it nothing is left.
class Film {
public:
    /// Throws Error that says what to install when there is no ffmpeg. `frame_ms`: how long a picture is shown.
    Film(const std::filesystem::path& path, int width, int height, double frame_ms);
    ~Film();
    Film(const Film&) = delete;
    Film& operator=(const Film&) = delete;

    void add(const Image& image);
    void close();

private:
    [[noreturn]] void fail();

    std::filesystem::path path_;
    StagedPath beside_;
    std::unique_ptr<std::FILE, int (*)(std::FILE*)> complaints_;  ///< what ffmpeg says on standard error
    pid_t ffmpeg_ = -1;
    int pipe_ = -1;
};

}  // namespace haptable
