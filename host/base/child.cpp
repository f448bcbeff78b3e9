// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/child.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

#include "host/base/error.hpp"

namespace haptable {

namespace {

constexpr std::size_t kMostKept_bytes = 1 << 20;

/// Both ends close on exec; ours does not wait.
std::array<int, 2> make_pipe(const std::string& name) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) throw Error(name + ": no pipe: " + std::strerror(errno));
    fcntl(ends[0], F_SETFL, O_NONBLOCK);
    return ends;
}

void close_one(int& fd) {
    if (fd >= 0) close(fd);
    fd = -1;
}

std::string last_line(std::string_view text) {
    while (!text.empty() && std::strchr("\r\n ", text.back()) != nullptr) text.remove_suffix(1);
    return std::string(text.substr(text.find_last_of("\r\n") + 1));
}

/// A signal that a program does not give itself.
bool is_from_outside(int status) {
    if (!WIFSIGNALED(status)) return false;
    const int signal = WTERMSIG(status);
    return signal == SIGKILL || signal == SIGTERM || signal == SIGINT || signal == SIGHUP;
}

}  // namespace

int spawn(const std::vector<std::string>& command, const std::array<int, 3>& streams, pid_t& id,
          const std::string& folder) {
    std::vector<char*> argv;
    for (const std::string& word : command) argv.push_back(const_cast<char*>(word.c_str()));
    argv.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    if (!folder.empty()) posix_spawn_file_actions_addchdir_np(&files, folder.c_str());
    for (int fd = 0; fd < 3; ++fd) {
        const int from = streams[static_cast<std::size_t>(fd)];
        if (from >= 0)
            posix_spawn_file_actions_adddup2(&files, from, fd);
        else
            posix_spawn_file_actions_addopen(&files, fd, "/dev/null", fd == 0 ? O_RDONLY : O_WRONLY, 0);
    }
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    const int failed = posix_spawnp(&id, argv[0], &files, &attributes, argv.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    return failed;
}

ShellResult run_shell(const std::string& command) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) != 0) throw Error(std::string("sh: no pipe: ") + std::strerror(errno));
    pid_t id = 0;
    const int failed = spawn({"sh", "-c", command}, {-1, ends[1], STDERR_FILENO}, id);
    close(ends[1]);
    ShellResult result;
    std::array<char, 4096> part{};
    for (ssize_t got = 1; failed == 0 && (got > 0 || errno == EINTR);) {
        got = read(ends[0], part.data(), part.size());
        if (got == 0) break;
        if (got > 0) result.out.append(part.data(), static_cast<std::size_t>(got));
    }
    close(ends[0]);
    if (failed != 0) throw Error(std::string("sh cannot be started: ") + std::strerror(failed));
    int status = 0;
    while (waitpid(id, &status, 0) < 0 && errno == EINTR) {
    }
    result.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return result;
}

Child::Child(std::string name, const std::vector<std::string>& command, const std::string& folder)
    : name_(std::move(name)) {
    // posix_spawn cannot ask the kernel for a signal at our death; setpriv (util-linux) can, and becomes the program.
    std::vector<std::string> words{"setpriv", "--pdeathsig", "TERM", "--"};
    words.insert(words.end(), command.begin(), command.end());
    std::array<int, 2> out = make_pipe(name_), err = make_pipe(name_);
    const int failed = spawn(words, {-1, out[1], err[1]}, id_, folder);
    close(out[1]);
    close(err[1]);
    out_.fd = out[0];
    err_.fd = err[0];
    // glibc 2.36 declares pidfd_open to C alone.
    if (failed == 0) end_ = static_cast<int>(syscall(SYS_pidfd_open, id_, 0));
    if (failed == 0 && end_ >= 0) return;
    const std::string why = std::strerror(failed != 0 ? failed : errno);
    if (failed != 0)
        id_ = 0;
    else
        wait(std::chrono::milliseconds(0));
    close_all();
    throw Error(name_ + ": cannot be started: " + why);
}

Child::~Child() {
    if (!has_ended()) wait(std::chrono::milliseconds(0));
    close_all();
}

void Child::close_all() {
    for (int* fd : {&end_, &out_.fd, &err_.fd}) close_one(*fd);
}

void Child::take(Pipe& from) {
    std::array<char, 4096> part{};
    while (from.fd >= 0) {
        const ssize_t got = read(from.fd, part.data(), part.size());
        if (got < 0) return;  // nothing waits
        if (got == 0) return close_one(from.fd);
        from.text.append(part.data(), static_cast<std::size_t>(got));
        if (from.text.size() <= kMostKept_bytes) continue;
        const std::size_t too_much = from.text.size() - kMostKept_bytes;
        from.text.erase(0, too_much);
        from.told -= std::min(from.told, too_much);
    }
}

void Child::look() {
    reap();
    // After the end: nothing comes any more.
    take(out_);
    take(err_);
}

void Child::reap() {
    if (id_ == 0) return;
    int status = 0;
    if (waitpid(id_, &status, WNOHANG) != id_) return;
    status_ = status;
    id_ = 0;
    close_one(end_);
}

void Child::ask_to_end() {
    if (id_ > 0 && !std::exchange(asked_, true)) kill(-id_, SIGTERM);
}

void Child::wait_some(std::chrono::milliseconds at_most) {
    std::array<pollfd, 3> from{pollfd{end_, POLLIN, 0}, pollfd{out_.fd, POLLIN, 0}, pollfd{err_.fd, POLLIN, 0}};
    poll(from.data(), from.size(), static_cast<int>(at_most.count()));
    look();
}

void Child::wait(std::chrono::milliseconds patience) {
    const auto give_up = std::chrono::steady_clock::now() + patience;
    for (look(); !has_ended();) {
        if (std::chrono::steady_clock::now() >= give_up && !std::exchange(killed_, true)) kill(-id_, SIGKILL);
        wait_some(std::chrono::milliseconds(100));
    }
}

std::vector<std::string> Child::new_lines() {
    std::vector<std::string> lines;
    for (std::size_t end = 0; (end = err_.text.find('\n', err_.told)) != std::string::npos; err_.told = end + 1)
        lines.push_back(err_.text.substr(err_.told, end - err_.told));
    return lines;
}

std::string Child::last_words() const { return last_line(err_.text); }

std::string Child::how_it_ended() const {
    std::string how;
    if (WIFSIGNALED(status_))
        how = fmt::format("{} was ended by signal {} ({})", name_, WTERMSIG(status_), strsignal(WTERMSIG(status_)));
    else
        how = fmt::format("{} ended with status {}", name_, WEXITSTATUS(status_));
    if (killed_) how += ", as it did not end by itself";
    const std::string words = is_from_outside(status_) ? "" : last_words();
    return words.empty() ? how : how + ": " + words;
}

}  // namespace haptable
