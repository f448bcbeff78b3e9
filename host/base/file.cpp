// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/file.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

#include "host/base/error.hpp"

namespace haptable {

std::string read_file(const std::filesystem::path& path) {
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored)) throw Error(path.string() + ": is a folder, not a file");
    errno = 0;
    std::ifstream in(path, std::ios::binary);
    if (!in) throw Error(path.string() + ": cannot be read: " + std::strerror(errno != 0 ? errno : EIO));
    std::ostringstream text;
    text << in.rdbuf();
    if (in.bad()) throw Error(path.string() + ": reading it failed");
    return std::move(text).str();
}

std::string read_text(const std::filesystem::path& path) {
    std::string text = read_file(path);
    if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff"))
        throw Error(path.string() + ": is text in UTF-16, which is not read here; save it as ASCII or UTF-8");
    if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);
    return text;
}

void write_file(const std::filesystem::path& path, std::string_view bytes) {
    Beside beside(path);
    errno = 0;
    std::ofstream out(beside.path(), std::ios::binary);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) throw Error(path.string() + ": cannot be written: " + std::strerror(errno != 0 ? errno : EIO));
    beside.commit();
}

// Renaming would put a file in the place of a link or, for root, of /dev/null.
Beside::Beside(std::filesystem::path final_path) : final_(std::move(final_path)) {
    std::error_code ignored;
    if (std::filesystem::is_symlink(final_, ignored)) final_ = std::filesystem::weakly_canonical(final_);
    if (std::filesystem::is_other(final_, ignored))
        throw Error(final_.string() + ": is a device or a pipe, which cannot be written whole: give a file's name");
    temporary_ = final_;
    temporary_ += ".partial-" + std::to_string(getpid());
}

Beside::~Beside() {
    std::error_code ignored;
    if (!temporary_.empty()) std::filesystem::remove_all(temporary_, ignored);
}

void Beside::commit() {
    std::error_code failed;
    std::filesystem::rename(temporary_, final_, failed);
    if (failed) throw Error(final_.string() + ": cannot be written: " + failed.message());
    temporary_.clear();
}

}  // namespace haptable
