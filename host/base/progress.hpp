// SPDX-License-Identifier: GPL-2.0-or-later
// A progress bar on a terminal, once work has taken more than a second; silence everywhere else.
#pragma once

#include <chrono>
#include <string>

namespace haptable {

class Progress {
public:
    /// `quiet` turns the bar off, as does a standard error that is not a terminal.
    explicit Progress(bool quiet);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// Names the stage that begins now; the share done starts at 0.
    void stage(const std::string& name);
    /// Says which share of the stage is done, 0 to 1, and stops the work here when Ctrl-C has come
    /// (throws Interrupted).
    void done(double share) { done(share, ""); }
    /// The same, with what was counted: "3,400 nodes".
    void done(double share, const std::string& detail);
    /// Takes the bar off the terminal.
    void clear();

private:
    using Clock = std::chrono::steady_clock;
    void draw(double share, const std::string& detail, Clock::time_point now);

    bool on_;
    bool drawn_ = false;
    std::string name_;
    Clock::time_point begin_;
    Clock::time_point stage_begin_;
    Clock::time_point last_;
};

}  // namespace haptable
