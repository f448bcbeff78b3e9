// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/mesh/in_child.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <clocale>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <new>

#include "host/base/error.hpp"
#include "host/base/interrupt.hpp"

namespace haptable {

namespace {

constexpr char kDone = 'd', kFailed = 'f', kNoMemory = 'm';

/// Kills and reaps the child where the parent leaves early.
class Child {
public:
    explicit Child(pid_t pid) : pid_(pid) {}
    ~Child() {
        if (pid_ <= 0) return;
        kill(pid_, SIGKILL);
        wait();
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;
    /// Its status as waitpid gives it.
    int wait() {
        int status = 0;
        while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
        }
        pid_ = -1;
        return status;
    }

private:
    pid_t pid_;
};

void bound(const ChildLimits& limits) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const rlim_t bytes = pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) + limits.memory_bytes;
    rlimit memory{};
    getrlimit(RLIMIT_AS, &memory);
    if (memory.rlim_cur == RLIM_INFINITY || memory.rlim_cur > bytes) memory.rlim_cur = bytes;
    setrlimit(RLIMIT_AS, &memory);
#endif
    const rlimit cpu{limits.cpu_s, limits.cpu_s + 1}, core{0, 0};
    setrlimit(RLIMIT_CPU, &cpu);
    setrlimit(RLIMIT_CORE, &core);
}

bool write_all(int to, const char* bytes, std::size_t count) {
    while (count > 0) {
        const ssize_t written = write(to, bytes, count);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return false;
        bytes += written;
        count -= static_cast<std::size_t>(written);
    }
    return true;
}

/// The child's whole life: it ends without destructors or atexit, which belong to the parent.
[[noreturn]] void live(int to, const ChildLimits& limits, ChildCount& count,
                       const std::function<std::string(ChildCount&)>& work) {
    for (int signal : {SIGINT, SIGTERM, SIGSEGV, SIGABRT}) std::signal(signal, SIG_DFL);
    prctl(PR_SET_PDEATHSIG, SIGKILL);  // nobody waits for the work of a parent that was killed
    std::setlocale(LC_ALL, "C");       // libraries read numbers by the locale
    // What a dying library prints is not for the user, who gets one line.
    if (std::freopen("/dev/null", "w", stdout) == nullptr || std::freopen("/dev/null", "w", stderr) == nullptr)
        _exit(1);
    bound(limits);
    char kind = kDone;
    std::string bytes;
    try {
        bytes = work(count);
    } catch (const Error& error) {
        kind = kFailed;
        bytes = error.what();
    } catch (const std::bad_alloc&) {
        kind = kNoMemory;
    } catch (const std::exception& error) {
        kind = kFailed;
        bytes = error.what();
    } catch (...) {
        _exit(1);
    }
    _exit(write_all(to, &kind, 1) && write_all(to, bytes.data(), bytes.size()) ? 0 : 1);
}

std::string read_all(int from, const ChildCount& child, const WatchChild& watch) {
    constexpr int kLook_ms = 100;
    std::string bytes;
    char block[65536];
    for (;;) {
        stop_if_interrupted();
        pollfd ready{from, POLLIN, 0};
        if (watch && poll(&ready, 1, kLook_ms) == 0) {
            watch(child);
            continue;
        }
        const ssize_t count = read(from, block, sizeof block);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return bytes;
        bytes.append(block, static_cast<std::size_t>(count));
    }
}

/// A count in memory that a forked child shares.
class SharedCount {
public:
    SharedCount() : map_(mmap(nullptr, sizeof(ChildCount), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) {
        if (map_ == MAP_FAILED) throw std::bad_alloc();
        count_ = new (map_) ChildCount();
    }
    ~SharedCount() { munmap(map_, sizeof(ChildCount)); }
    SharedCount(const SharedCount&) = delete;
    SharedCount& operator=(const SharedCount&) = delete;
    ChildCount& operator*() const { return *count_; }

private:
    void* map_;
    ChildCount* count_ = nullptr;
};

/// Closes a descriptor at the end.
struct Descriptor {
    int fd;
    ~Descriptor() { close(fd); }
};

}  // namespace

std::string run_in_child(const std::string& what, const ChildLimits& limits,
                         const std::function<std::string(ChildCount&)>& work, const WatchChild& watch) {
    const SharedCount count;
    int ends[2];
    if (pipe(ends) != 0) throw Error(fmt::format("{}: no pipe: {}", what, std::strerror(errno)));
    std::fflush(nullptr);
    const pid_t pid = fork();
    if (pid < 0) {
        close(ends[0]);
        close(ends[1]);
        throw Error(fmt::format("{}: no new process: {}", what, std::strerror(errno)));
    }
    if (pid == 0) {
        close(ends[0]);
        live(ends[1], limits, *count, work);
    }
    close(ends[1]);
    const Descriptor from{ends[0]};
    Child child(pid);
    std::string bytes = read_all(from.fd, *count, watch);
    const int status = child.wait();
    if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL))
        throw Error(fmt::format("{}: gave up after {} s of work or out of memory; the file is damaged, or too large",
                                what, limits.cpu_s));
    if (WIFSIGNALED(status) || bytes.empty() || WEXITSTATUS(status) != 0)
        throw Error(fmt::format("{}: the library broke down over it; the file is damaged: save it again", what));
    const char kind = bytes[0];
    if (kind == kNoMemory) throw Error(fmt::format("{}: needs more memory than its size allows; it is damaged", what));
    bytes.erase(0, 1);
    if (kind == kFailed) throw Error(bytes);
    return bytes;
}

}  // namespace haptable
