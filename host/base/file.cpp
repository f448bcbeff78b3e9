// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <mutex>
#include <set>
#include <sstream>

#include "host/base/error.hpp"

namespace haptable {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kUnderConstruction = ".haptable-";

std::string why(int error) { return std::strerror(error != 0 ? error : EIO); }

bool is_under_construction(const std::string& name) {
    const std::size_t at = name.rfind(kUnderConstruction);
    if (at == std::string::npos || at == 0) return false;
    const std::string_view process = std::string_view(name).substr(at + kUnderConstruction.size());
    return !process.empty() && process.find_first_not_of("0123456789") == std::string_view::npos;
}

/// Removes it where it is a file or folder of this user's, whose lock nobody holds.
void remove_leftover(const fs::path& path) {
    const int file = open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (file < 0) return;
    struct stat status {};
    std::error_code ignored;
    if (fstat(file, &status) == 0 && status.st_uid == geteuid() &&
        (S_ISREG(status.st_mode) || S_ISDIR(status.st_mode)) && flock(file, LOCK_EX | LOCK_NB) == 0 &&
        names_open(path, file))
        fs::remove_all(path, ignored);
    ::close(file);
}

/// Once in a process's life: a folder of many files is not gone through for each of them.
void remove_leftovers_once(const fs::path& folder) {
    static std::mutex mutex;
    static std::set<fs::path> done;
    const std::lock_guard guard(mutex);
    if (done.insert(folder).second) remove_leftovers(folder);
}

}  // namespace

std::string read_file(const fs::path& path) {
    std::error_code ignored;
    if (fs::is_directory(path, ignored)) throw Error(path.string() + ": is a folder, not a file");
    errno = 0;
    std::ifstream in(path, std::ios::binary);
    if (!in) throw Error(path.string() + ": cannot be read: " + why(errno));
    std::ostringstream text;
    text << in.rdbuf();
    if (in.bad()) throw Error(path.string() + ": reading it failed");
    return std::move(text).str();
}

std::string read_text(const fs::path& path) {
    std::string text = read_file(path);
    if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff"))
        throw Error(path.string() + ": is text in UTF-16, which is not read here; save it as ASCII or UTF-8");
    if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);
    return text;
}

void write_file(const fs::path& path, std::string_view bytes) {
    StagedPath beside(path);
    errno = 0;
    std::ofstream out(beside.path(), std::ios::binary);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) throw Error(path.string() + ": cannot be written: " + why(errno));
    beside.commit();
}

// Renaming would put a file in the place of a link or, for root, of /dev/null.
StagedPath::StagedPath(fs::path final_path, StagedKind kind) : final_(std::move(final_path)) {
    std::error_code ignored;
    if (fs::is_symlink(final_, ignored)) final_ = fs::weakly_canonical(final_);
    if (fs::is_other(final_, ignored))
        throw Error(final_.string() + ": is a device or a pipe, which cannot be written whole: give a file's name");
    temporary_ = final_;
    temporary_ += std::string(kUnderConstruction) + std::to_string(getpid());
    remove_leftovers_once(final_.parent_path());
    make(kind);
}

/// Locked, so that it is nobody's leftover. Between the two it may have been taken for one: then once more. Where a
/// file system has no locks, nobody takes it for one.
void StagedPath::make(StagedKind kind) {
    constexpr int kNew = O_RDWR | O_CREAT | O_EXCL;
    do {
        close();
        errno = 0;
        if (kind == StagedKind::folder && mkdir(temporary_.c_str(), 0777) != 0)
            throw Error(final_.string() + ": cannot be written: " + why(errno));
        descriptor_ = open(temporary_.c_str(),
                           (kind == StagedKind::folder ? O_RDONLY | O_DIRECTORY : kNew) | O_NOFOLLOW | O_CLOEXEC, 0666);
        if (descriptor_ < 0 && (kind == StagedKind::file || errno != ENOENT))
            throw Error(final_.string() + ": cannot be written: " + why(errno));
        flock(descriptor_, LOCK_EX);
    } while (descriptor_ < 0 || !names_open(temporary_, descriptor_));
}

StagedPath::~StagedPath() {
    std::error_code ignored;
    if (!temporary_.empty()) fs::remove_all(temporary_, ignored);
    close();
}

void StagedPath::close() {
    if (descriptor_ >= 0) ::close(descriptor_);
    descriptor_ = -1;
}

void StagedPath::commit() {
    std::error_code failed;
    fs::rename(temporary_, final_, failed);
    if (failed) throw Error(final_.string() + ": cannot be written: " + failed.message());
    temporary_.clear();
    close();
}

bool names_open(const fs::path& path, int descriptor) {
    struct stat by_path {
    }, open{};
    return lstat(path.c_str(), &by_path) == 0 && fstat(descriptor, &open) == 0 && by_path.st_ino == open.st_ino &&
           by_path.st_dev == open.st_dev;
}

void remove_leftovers(const fs::path& folder) {
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder.empty() ? "." : folder, ignored))
        if (is_under_construction(entry.path().filename().string())) remove_leftover(entry.path());
}

}  // namespace haptable
