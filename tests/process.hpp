// SPDX-License-Identifier: GPL-2.0-or-later
// Programs that a test runs: none outlives it, and one that hangs fails the test instead of stopping the suite.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace haptable::test {

/// $BUILD, or build.
std::filesystem::path build_folder();
/// A program of ours, by an absolute path: program("haptable-view").
std::filesystem::path program(const std::string& name);

/// How a program ended.
struct Outcome {
    int status = 0;  ///< its exit status; -signal where a signal ended it
    std::string out, err;
};

/// Runs a command of the shell in `folder` (here, where it is empty) until it ends. After `patience` it is killed, with
/// all that it started, and the test fails.
Outcome run(const std::string& command, const std::filesystem::path& folder = {},
            std::chrono::seconds patience = std::chrono::minutes(10));

/// How a new process ends that does this: with what it returns, up to 100; or -signal.
int status_of(const std::function<int()>& act);

/// A program beside the test. It leads a process group of its own, which ends with this object.
class Process {
public:
    /// Where it runs, and where its output goes.
    struct Place {
        std::filesystem::path folder;  ///< here, where it is empty
        std::string out = "/dev/null";
        std::string err;  ///< empty: the test's own
    };

    /// Throws std::runtime_error where there is no such program.
    explicit Process(const std::vector<std::string>& command);
    Process(const std::vector<std::string>& command, const Place& place);
    ~Process();
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;

    pid_t id() const { return id_; }
    void kill(int signal) const;
    /// Its exit status, -signal where a signal ended it. After `patience` it is killed, and the test fails.
    int wait_for_exit(std::chrono::seconds patience = std::chrono::minutes(10));

private:
    bool reap();
    void end();

    std::string name_;
    pid_t id_ = 0;
    int status_ = 0;
};

}  // namespace haptable::test
