// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/link/text_file.hpp"

#include <cerrno>
#include <cstring>

#include "host/base/error.hpp"

namespace haptable {

namespace {

// One write to the disk for some hundred lines.
constexpr std::size_t kFlush_bytes = 65536;

}  // namespace

TextFile::TextFile(const std::filesystem::path& path)
    : path_(path), beside_(path), file_(std::fopen(beside_.path().c_str(), "wb")) {
    if (file_ == nullptr) throw Error(path.string() + ": cannot be written: " + std::strerror(errno));
    std::setvbuf(file_, nullptr, _IONBF, 0);  // we have a buffer of our own
    buffer_.reserve(2 * kFlush_bytes);
}

TextFile::~TextFile() {
    if (file_ != nullptr) std::fclose(file_);
}

void TextFile::add(std::string_view text) {
    buffer_ += text;
    if (buffer_.size() >= kFlush_bytes) flush();
}

void TextFile::flush() {
    errno = 0;
    if (std::fwrite(buffer_.data(), 1, buffer_.size(), file_) != buffer_.size() && error_ == 0)
        error_ = errno != 0 ? errno : EIO;
    buffer_.clear();
}

void TextFile::finish() {
    flush();
    if (std::fclose(file_) != 0 && error_ == 0) error_ = errno;
    file_ = nullptr;
    if (error_ != 0) throw Error(path_.string() + ": cannot be written: " + std::strerror(error_));
    beside_.commit();
}

}  // namespace haptable
