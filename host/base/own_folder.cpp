// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/own_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

#include "host/base/error.hpp"
#include "host/base/file.hpp"

namespace haptable {

namespace fs = std::filesystem;

namespace {

constexpr const char* kMark = ".haptable";
constexpr const char* kOtherFolder = "give a new or an empty folder";

std::vector<std::string> lines_of(const fs::path& file) {
    std::istringstream text(read_file(file));
    std::vector<std::string> lines;
    for (std::string line; std::getline(text, line);) lines.push_back(line);
    return lines;
}

/// Who holds the lock of an open file, by /proc/locks: "1: FLOCK ADVISORY WRITE 708 08:01:1234 0 EOF".
std::string holder_of(int descriptor) {
    struct stat file {};
    fstat(descriptor, &file);
    const std::string inode = fmt::format(":{}", file.st_ino);
    std::ifstream locks("/proc/locks");
    for (std::string line; std::getline(locks, line);) {
        std::istringstream words(line);
        std::string number, kind, way, what, process, where;
        if (words >> number >> kind >> way >> what >> process >> where && kind == "FLOCK" && where.ends_with(inode))
            return "process " + process;
    }
    return "another process";
}

bool is_there(const fs::path& path) {
    std::error_code none;
    return fs::exists(fs::symlink_status(path, none));
}

}  // namespace

OwnFolder::OwnFolder(fs::path folder, const std::string& holds, const std::vector<std::string>& known)
    : folder_(std::move(folder)), mark_(folder_ / kMark) {
    std::error_code failed;
    if (fs::exists(folder_, failed) && !fs::is_directory(folder_, failed))
        fail("is a file, and a folder is to be written; give another -o");
    made_ = fs::create_directories(folder_, failed);
    if (failed) fail("cannot be written: " + failed.message());
    try {
        while (!open_once(known)) {
        }
        read(holds, known);
    } catch (...) {
        if (descriptor_ >= 0) ::close(descriptor_);
        throw;
    }
    remove_leftovers(folder_);
}

/// False where another process made or removed the mark meanwhile.
bool OwnFolder::open_once(const std::vector<std::string>& known) {
    if (descriptor_ >= 0) ::close(descriptor_);
    constexpr int kHow = O_RDWR | O_APPEND | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;
    descriptor_ = ::open(mark_.c_str(), kHow);
    if (descriptor_ < 0 && errno == ENOENT) {
        require_no_others(known);
        descriptor_ = ::open(mark_.c_str(), kHow | O_CREAT | O_EXCL, 0666);
        if (descriptor_ < 0 && errno == EEXIST) return false;
    }
    if (descriptor_ < 0 && errno == ELOOP) fail(fmt::format("its {} is a link: {}", kMark, kOtherFolder));
    if (descriptor_ < 0) fail(fmt::format("cannot be written: {}", std::strerror(errno)));
    if (flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return names_open(mark_, descriptor_);
    if (errno != EWOULDBLOCK) fail(fmt::format("{}: cannot be locked: {}", kMark, std::strerror(errno)));
    fail(fmt::format("{} is writing it: wait until it ends, or give another -o", holder_of(descriptor_)));
}

void OwnFolder::read(const std::string& holds, const std::vector<std::string>& known) {
    struct stat mark {
    }, folder{};
    if (fstat(descriptor_, &mark) != 0 || !S_ISREG(mark.st_mode) || stat(folder_.c_str(), &folder) != 0)
        fail(fmt::format("its {} is no file: {}", kMark, kOtherFolder));
    if (mark.st_uid != geteuid() && mark.st_uid != folder.st_uid)
        fail(fmt::format("its {} is another user's: {}", kMark, kOtherFolder));
    std::vector<std::string> lines = lines_of(mark_);
    const std::string first = "haptable " + holds;
    if (lines.empty()) {  // new, or its maker was killed just then
        require_no_others(known);
        append(first + (made_ ? "\n." : ""));
        for (const std::string& name : known) append(name);
        lines = lines_of(mark_);
    }
    if (!lines.front().starts_with("haptable ")) fail(fmt::format("its {} is not haptable's: {}", kMark, kOtherFolder));
    if (lines.front() != first)
        fail(fmt::format("holds haptable's {}, not {}: {}", lines.front().substr(9), holds, kOtherFolder));
    for (const std::string& line : lines)
        if (line.find('/') == std::string::npos && line != ".." && line != kMark) ours_.insert(line);
    ours_.erase(first);
    made_ = ours_.erase(".") > 0;
}

OwnFolder::~OwnFolder() {
    std::error_code ignored;
    if (has_only_mark()) {
        fs::remove(mark_, ignored);
        if (made_) fs::remove(folder_, ignored);
    }
    ::close(descriptor_);
}

/// Refuses a folder without a mark that holds other files.
void OwnFolder::require_no_others(const std::vector<std::string>& known) const {
    const bool is_known =
        std::any_of(known.begin(), known.end(), [&](const auto& name) { return is_there(folder_ / name); });
    if (!is_known && !has_only_mark())
        fail(fmt::format("holds files that haptable did not write (it has no {}): {}", kMark, kOtherFolder));
}

bool OwnFolder::has_only_mark() const {
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_, ignored))
        if (entry.path().filename() != kMark) return false;
    return true;
}

fs::path OwnFolder::file(const std::string& name) {
    fs::path path = folder_ / name;
    if (ours_.contains(name)) return path;
    if (is_there(path))
        throw Error(path.string() + ": is not haptable's, and would be written over: move it away, or give another -o");
    append(name);
    ours_.insert(name);
    return path;
}

void OwnFolder::remove(const std::string& name) {
    std::error_code failed;
    if (ours_.contains(name)) fs::remove_all(folder_ / name, failed);
    if (failed) fail(fmt::format("{} cannot be removed: {}", name, failed.message()));
}

void OwnFolder::clear(const std::set<std::string>& kept) {
    for (const std::string& name : ours_)
        if (!kept.contains(name)) remove(name);
}

/// A disk that is full takes no part of a line.
void OwnFolder::append(const std::string& line) const {
    const std::string text = line + "\n";
    struct stat before {};
    fstat(descriptor_, &before);
    errno = 0;
    if (write(descriptor_, text.data(), text.size()) == static_cast<ssize_t>(text.size())) return;
    const int why = errno != 0 ? errno : ENOSPC;
    [[maybe_unused]] const int ignored = ftruncate(descriptor_, before.st_size);
    fail(fmt::format("cannot be written: {}", std::strerror(why)));
}

void OwnFolder::fail(const std::string& why) const { throw Error(fmt::format("{}: {}", folder_.string(), why)); }

}  // namespace haptable
