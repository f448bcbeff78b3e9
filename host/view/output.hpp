// SPDX-License-Identifier: GPL-2.0-or-later
// Where pictures go: a folder of PNGs, one PNG, or a film.
#pragma once

#include <filesystem>
#include <future>
#include <memory>
#include <vector>

#include "host/view/film.hpp"
#include "host/view/image.hpp"

namespace haptable {

/// Pictures are compressed and written beside the drawing of the next one.
class Output {
public:
    /// By the suffix of `path`: .png, a film's, or else a folder, which is made and cleared of the frames of an
    /// earlier run; a new folder goes again when no picture came. Throws Error for another picture's or film's suffix.
    Output(const std::filesystem::path& path, int width, int height, double frame_ms);
    /// What was not closed was broken off: nothing of it is left, and standard error says so.
    ~Output();

    /// True when only one picture has room.
    bool single() const { return kind_ == Kind::picture; }
    /// The folder that holds the pictures, or nothing.
    const std::filesystem::path* folder() const { return kind_ == Kind::folder ? &path_ : nullptr; }
    /// Compresses and writes it beside the caller's next work. A file beside the picture that the caller writes into
    /// folder(): its name goes with the pictures of a run that is broken off.
    void add(const Image& image);
    void note_file(const std::filesystem::path& file) { files_.push_back(file); }
    /// Waits until all is written. Throws what went wrong.
    void close();

private:
    enum class Kind { folder, picture, film };

    std::filesystem::path path_;
    Kind kind_;
    std::unique_ptr<Film> film_;
    bool made_ = false;                         ///< the folder is new
    bool closed_ = false;                       ///< close() was called, and came to its end
    std::vector<std::filesystem::path> files_;  ///< in the folder
    std::size_t frames_ = 0;
    Image writing_;
    std::future<void> pending_;
};

}  // namespace haptable
