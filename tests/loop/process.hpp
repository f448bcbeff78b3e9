// SPDX-License-Identifier: GPL-2.0-or-later
// A program that a test starts, and that never outlives it.
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace haptable::test {

class Process {
public:
    /// Starts it; what it prints is of no interest here (its files and messages are).
    explicit Process(const std::vector<std::string>& command) {
        std::vector<char*> argv;
        for (const std::string& word : command) argv.push_back(const_cast<char*>(word.c_str()));
        argv.push_back(nullptr);
        posix_spawn_file_actions_t files;
        posix_spawn_file_actions_init(&files);
        posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
        const int failed = posix_spawnp(&id_, argv[0], &files, nullptr, argv.data(), environ);
        posix_spawn_file_actions_destroy(&files);
        if (failed != 0) throw std::runtime_error("cannot start " + command[0]);
    }
    ~Process() {
        if (id_ <= 0) return;
        ::kill(id_, SIGKILL);
        wait_for_exit();
    }
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;

    void kill(int signal) const { ::kill(id_, signal); }
    /// Its exit status, -signal when a signal ended it; a program that has not ended after a minute is killed.
    int wait_for_exit() {
        for (int tries = 0; tries < 6000; ++tries) {
            if (reap(WNOHANG)) return status_;
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
        ::kill(id_, SIGKILL);
        reap(0);
        return status_;
    }

private:
    bool reap(int options) {
        int status = 0;
        if (id_ <= 0 || waitpid(id_, &status, options) != id_) return id_ <= 0;
        status_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
        id_ = 0;
        return true;
    }

    pid_t id_ = 0;
    int status_ = 0;
};

}  // namespace haptable::test
