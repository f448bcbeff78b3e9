// SPDX-License-Identifier: GPL-2.0-or-later
// Programs that run beside this one: all are started here.
#pragma once

#include <sys/types.h>

#include <array>
#include <chrono>
#include <string>
#include <vector>

namespace haptable {

/// Starts a command, found by PATH, with these as its standard input, output and error (-1: /dev/null), in `folder`, or
/// here where that is empty. It has a process group of its own: a terminal's Ctrl-C reaches us alone, and we end it.
/// Returns 0, or the error number.
int spawn(const std::vector<std::string>& command, const std::array<int, 3>& streams, pid_t& id,
          const std::string& folder = {});

/// What a shell's command came to.
struct ShellResult {
    int status = 0;   ///< of its exit; -1: a signal ended it
    std::string out;  ///< all that it printed on standard output
};
/// Waits for its end. Throws Error where no shell can be started.
ShellResult run_shell(const std::string& command);

/// A program that is heard while it runs, and never left behind.
class Child {
public:
    /// Starts it as spawn does. The kernel ends it where we are killed. `name` is for messages. Throws Error where it
    /// cannot be started.
    Child(std::string name, const std::vector<std::string>& command, const std::string& folder = {});
    /// Killed, with all that it started, where it still runs.
    ~Child();
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    const std::string& name() const { return name_; }
    /// For poll: readable when it has ended, or has said something on standard output or error; -1: closed.
    std::array<int, 3> fds() const { return {end_, out_.fd, err_.fd}; }
    /// Takes what it has said and whether it has ended, without waiting.
    void look();
    bool has_ended() const { return id_ == 0; }
    /// An ended one ended by itself, with status 0.
    bool is_well() const { return status_ == 0; }
    /// SIGTERM, once.
    void ask_to_end();
    /// Waits for its end, or that it says something, so long at the most.
    void wait_some(std::chrono::milliseconds at_most);
    /// Waits for its end; after `patience` it is killed.
    void wait(std::chrono::milliseconds patience);

    /// All that it printed, up to 1 MiB.
    const std::string& out() const { return out_.text; }
    /// The whole lines that came on its standard error since the last call.
    std::vector<std::string> new_lines();
    /// The last of them all, empty where there is none.
    std::string last_words() const;
    /// How an ended one ended, in words, with its last ones. A signal from outside comes without any.
    std::string how_it_ended() const;

private:
    struct Pipe {
        int fd = -1;
        std::string text;
        std::size_t told = 0;  ///< bytes of it that new_lines() has given
    };
    static void take(Pipe& from);
    void reap();
    void close_all();

    std::string name_;
    pid_t id_ = 0;
    int end_ = -1;  ///< pidfd
    Pipe out_, err_;
    bool asked_ = false, killed_ = false;
    int status_ = 0;  ///< as waitpid gives it
};

}  // namespace haptable
