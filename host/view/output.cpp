// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <string>

#include "host/base/error.hpp"
#include "host/view/png.hpp"
#include "host/view/vtu.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

/// Suffixes that ask for something we do not write.
bool is_foreign(const fs::path& path) {
    static const std::string known[] = {".jpg", ".jpeg", ".bmp", ".ppm",  ".svg",  ".pdf", ".tif",
                                        ".avi", ".mov",  ".mkv", ".webm", ".webp", ".csv", ".vtu"};
    return std::find(std::begin(known), std::end(known), path.extension()) != std::end(known);
}

}  // namespace

Output::Output(const fs::path& path, int width, int height, double frame_ms) : path_(path), kind_(Kind::folder) {
    if (!fs::is_directory(path) && path.extension() == ".png") {
        kind_ = Kind::picture;
    } else if (!fs::is_directory(path) && is_film(path)) {
        kind_ = Kind::film;
        film_ = std::make_unique<Film>(path, width, height, frame_ms);
    } else if (!fs::is_directory(path) && is_foreign(path)) {
        throw Error(path.string() +
                    ": pictures are written as .png, .svg, .pdf, .mp4, .gif or into a folder: give one of these");
    } else {
        folder_ = std::make_unique<OwnFolder>(path, kPictures);
        folder_->clear();
    }
}

Output::~Output() {
    if (pending_.valid()) pending_.wait();
    if (closed_) return;
    if (folder_) folder_->clear();
    if (frames_ > 0 && !single())
        fmt::print(stderr, "haptable-view: {} was broken off after {} pictures: nothing of it is left\n",
                   path_.string(), frames_);
}

void Output::add(const Image& image) {
    if (single() && frames_ > 0) throw Error(path_.string() + ": holds one picture only: give a folder");
    if (pending_.valid()) pending_.get();
    writing_ = image;
    const fs::path file = folder_ ? folder_->file(frame_name(frames_) + ".png") : path_;
    ++frames_;
    pending_ = std::async(std::launch::async, [this, file] {
        if (film_)
            film_->add(writing_);
        else
            write_png(file, writing_);
    });
}

void Output::close() {
    if (pending_.valid()) pending_.get();
    if (film_) film_->close();
    closed_ = true;
}

}  // namespace haptable
