// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/folder_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>
#include <string>

#include "host/base/error.hpp"
#include "host/base/file.hpp"

namespace haptable {

namespace fs = std::filesystem;

namespace {

std::string own_name() {
    std::array<char, 256> host{};
    gethostname(host.data(), host.size() - 1);
    return fmt::format("process {} on {}", getpid(), host.data());
}

/// What the holder wrote; it may not have done so yet.
std::string holder_of(const fs::path& file) {
    std::string text;
    try {
        text = read_file(file);
    } catch (const Error&) {  // gone meanwhile
    }
    return text.empty() ? "another process" : text;
}

/// Whether the path still names the open file: a holder removes it before letting go.
bool names(const fs::path& path, int descriptor) {
    struct stat by_path {
    }, open{};
    return stat(path.c_str(), &by_path) == 0 && fstat(descriptor, &open) == 0 && by_path.st_ino == open.st_ino &&
           by_path.st_dev == open.st_dev;
}

bool is_running(pid_t process) { return kill(process, 0) == 0 || errno == EPERM; }

}  // namespace

FolderLock::FolderLock(const fs::path& folder) : file_(folder.string() + ".lock") {
    const auto fail = [&](const std::string& why) { throw Error(fmt::format("{}: {}", folder.string(), why)); };
    std::error_code failed;
    fs::create_directories(folder.parent_path(), failed);
    if (failed) fail("cannot be written: " + failed.message());
    while (descriptor_ < 0) {
        descriptor_ = open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
        if (descriptor_ < 0) fail(fmt::format("cannot be written: {}", std::strerror(errno)));
        const bool locked = flock(descriptor_, LOCK_EX | LOCK_NB) == 0;
        const int why = errno;
        if (locked && names(file_, descriptor_)) break;
        close(descriptor_);
        descriptor_ = -1;
        if (locked) continue;
        if (why == EWOULDBLOCK)
            fail(fmt::format("{} is writing it: wait until it ends, or give another -o", holder_of(file_)));
        fail(fmt::format("{}: cannot be locked: {}", file_.filename().string(), std::strerror(why)));
    }
    // Where the disk is full it is held all the same, and others see no name.
    const std::string name = own_name();
    [[maybe_unused]] const bool said =
        ftruncate(descriptor_, 0) == 0 && write(descriptor_, name.data(), name.size()) > 0;
}

FolderLock::~FolderLock() {
    std::error_code ignored;
    fs::remove(file_, ignored);
    close(descriptor_);
}

void remove_leftovers(const fs::path& folder) {
    const std::string begin = folder.filename().string() + ".partial-";
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder.parent_path(), ignored)) {
        const std::string name = entry.path().filename().string();
        if (name.rfind(begin, 0) != 0) continue;
        pid_t process = 0;
        const char* end = name.data() + name.size();
        const auto [rest, error] = std::from_chars(name.data() + begin.size(), end, process);
        if (error != std::errc() || rest != end || process <= 0) continue;
        // A number like this process's own was another's, before it was given anew.
        if (process == getpid() || !is_running(process)) fs::remove_all(entry.path(), ignored);
    }
}

}  // namespace haptable
