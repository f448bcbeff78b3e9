// SPDX-License-Identifier: GPL-2.0-or-later
// Where pictures go: a folder of PNGs, one PNG, or a film.
#pragma once

#include <filesystem>
#include <future>
#include <memory>

#include "host/base/own_folder.hpp"
#include "host/view/film.hpp"
#include "host/view/image.hpp"

namespace haptable {

/// Pictures are compressed and written beside the drawing of the next one.
class Output {
public:
    /// By the suffix of `path`: .png, a film's, or else a folder, which is made, or cleared of what an earlier run
    /// made; a new folder goes again when no picture came. Throws Error for another picture's or film's suffix, and for
    /// a folder with files that haptable did not write.
    Output(const std::filesystem::path& path, int width, int height, double frame_ms);
    /// What was not closed was broken off: nothing of it is left, and standard error says so.
    ~Output();

    /// True when only one picture has room.
    bool single() const { return kind_ == Kind::picture; }
    /// The folder that holds the pictures, or nothing. What else is written into it goes with them where a run is
    /// broken off.
    OwnFolder* folder() const { return folder_.get(); }
    /// Compresses and writes it beside the caller's next work.
    void add(const Image& image);
    /// Waits until all is written. Throws what went wrong.
    void close();

private:
    enum class Kind { folder, picture, film };

    std::filesystem::path path_;
    Kind kind_;
    std::unique_ptr<Film> film_;
    std::unique_ptr<OwnFolder> folder_;
    bool closed_ = false;  ///< close() was called, and came to its end
    std::size_t frames_ = 0;
    Image writing_;
    std::future<void> pending_;
};

}  // namespace haptable
