// SPDX-License-Identifier: GPL-2.0-or-later
// Where pictures go: a folder of PNGs, one PNG, or a film.
#pragma once

#include <filesystem>
#include <future>
#include <memory>

#include "host/view/film.hpp"
#include "host/view/image.hpp"

namespace haptable {

/// Pictures are compressed and written beside the drawing of the next one.
class Output {
public:
    /// By the suffix of `path`: .png, a film's, or else a folder, which is made and cleared of the frames of an
    /// earlier run; a new folder goes again when no picture came. Throws Error for another picture's or film's suffix.
    Output(const std::filesystem::path& path, int width, int height, double frame_ms);
    ~Output();

    /// True when only one picture has room.
    bool single() const { return kind_ == Kind::picture; }
    /// The folder that holds the pictures, or nothing.
    const std::filesystem::path* folder() const { return kind_ == Kind::folder ? &path_ : nullptr; }
    void add(const Image& image);
    /// Waits until all is written. Throws what went wrong.
    void close();

private:
    enum class Kind { folder, picture, film };

    std::filesystem::path path_;
    Kind kind_;
    std::unique_ptr<Film> film_;
    bool made_ = false;  ///< the folder is new
    std::size_t frames_ = 0;
    Image writing_;
    std::future<void> pending_;
};

}  // namespace haptable
