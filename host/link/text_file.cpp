// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/link/text_file.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "host/base/error.hpp"

namespace haptable {

namespace {

// One write to the disk for some hundred lines.
constexpr std::size_t kFlush_bytes = 65536;

}  // namespace

void require_other_file(const std::filesystem::path& out, const std::filesystem::path& in, const std::string& option) {
    std::error_code none;
    if (std::filesystem::weakly_canonical(in, none) == std::filesystem::weakly_canonical(out, none))
        throw Error(out.string() + ": is what " + option + " reads: write to another name");
}

TextFile::TextFile(const std::filesystem::path& path)
    : path_(path), beside_(path), file_(std::fopen(beside_.path().c_str(), "wb")) {
    if (file_ == nullptr) throw Error(path.string() + ": cannot be written: " + std::strerror(errno));
    std::setvbuf(file_, nullptr, _IONBF, 0);  // we have a buffer of our own
    buffer_.reserve(2 * kFlush_bytes);
}

TextFile::~TextFile() {
    if (file_ == nullptr) return;
    if (kept_) flush();
    std::fclose(file_);
}

void TextFile::keep() {
    flush();
    if (error_ != 0) throw Error(path_.string() + ": cannot be written: " + std::strerror(error_));
    beside_.commit();
    kept_ = true;
}

void TextFile::add(std::string_view lines) {
    buffer_ += lines;
    if (buffer_.size() >= kFlush_bytes) flush();
}

void TextFile::flush() {
    if (error_ == 0 && !buffer_.empty()) {
        errno = 0;
        if (std::fwrite(buffer_.data(), 1, buffer_.size(), file_) == buffer_.size()) {
            size_bytes_ += static_cast<long>(buffer_.size());
        } else {
            error_ = errno != 0 ? errno : EIO;
            // A full disk took half a line: what was there before is whole.
            if (ftruncate(fileno(file_), size_bytes_) != 0) error_ = errno;
        }
    }
    buffer_.clear();
}

void TextFile::finish() {
    flush();
    if (std::fclose(file_) != 0 && error_ == 0) error_ = errno;
    file_ = nullptr;
    if (error_ != 0) throw Error(path_.string() + ": cannot be written: " + std::strerror(error_));
    if (!kept_) beside_.commit();
}

}  // namespace haptable
