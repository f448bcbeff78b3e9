// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/process.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <stdexcept>
#include <thread>

#include "host/base/file.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {

std::filesystem::path build_folder() {
    const char* build = std::getenv("BUILD");
    return build != nullptr && *build != '\0' ? build : "build";
}

std::filesystem::path program(const std::string& name) {
    return std::filesystem::absolute(build_folder()) / "bin" / name;
}

Outcome run(const std::string& command, const std::filesystem::path& folder, std::chrono::seconds patience) {
    const TemporaryFolder scratch;
    const std::string out = (scratch.path() / "out").string(), err = (scratch.path() / "err").string();
    Process process({"sh", "-c", command}, {folder, out, err});
    const int status = process.wait_for_exit(patience);
    return {status, read_file(out), read_file(err)};
}

int status_of(const std::function<int()>& act) {
    const pid_t child = fork();
    if (child == 0) _exit(act());
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

Process::Process(const std::vector<std::string>& command) : Process(command, Place{}) {}

Process::Process(const std::vector<std::string>& command, const Place& place) : name_(command.back()) {
    std::vector<char*> argv;
    for (const std::string& word : command) argv.push_back(const_cast<char*>(word.c_str()));
    argv.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    const auto send = [&files](int to, const std::string& file) {
        posix_spawn_file_actions_addopen(&files, to, file.c_str(), O_WRONLY | O_CREAT, 0600);
    };
    send(STDOUT_FILENO, place.out);
    if (!place.err.empty()) send(STDERR_FILENO, place.err);
    if (!place.folder.empty()) posix_spawn_file_actions_addchdir_np(&files, place.folder.c_str());
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    const int failed = posix_spawnp(&id_, argv[0], &files, &attributes, argv.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    if (failed != 0) throw std::runtime_error("cannot start " + command[0]);
}

Process::~Process() { end(); }

void Process::kill(int signal) const {
    if (id_ > 0) ::kill(id_, signal);
}

int Process::wait_for_exit(std::chrono::seconds patience) {
    const auto give_up = std::chrono::steady_clock::now() + patience;
    while (!reap()) {
        if (std::chrono::steady_clock::now() > give_up) {
            ADD_FAILURE() << "killed, it had not ended after " << patience.count() << " s: " << name_;
            end();
            break;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return status_;
}

/// True when it has ended.
bool Process::reap() {
    int status = 0;
    if (id_ > 0 && waitpid(id_, &status, WNOHANG) == 0) return false;
    if (id_ > 0) status_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    id_ = 0;
    return true;
}

/// Ends the whole group, and waits for its leader.
void Process::end() {
    if (id_ <= 0 || reap()) return;
    ::kill(-id_, SIGKILL);
    int status = 0;
    waitpid(id_, &status, 0);
    status_ = -SIGKILL;
    id_ = 0;
}

}  // namespace haptable::test
