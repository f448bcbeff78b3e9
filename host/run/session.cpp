// SPDX-License-Identifier: GPL-2.0-or-later
// log -> servo, or QEMU and bridge -> viewer -> device; then the same, last to first
#include "host/run/session.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include "host/base/child.hpp"
#include "host/base/error.hpp"
#include "host/base/interrupt.hpp"
#include "host/run/recorder.hpp"

namespace haptable {

namespace {

// A program that was asked to end writes its record and its summary: on a slow disk too.
constexpr std::chrono::seconds kPatience{10};
constexpr std::chrono::milliseconds kFlush{100};
constexpr std::chrono::seconds kLine{1};

std::string in(const std::filesystem::path& folder, const char* name) { return (folder / name).string(); }

class RunningSession {
public:
    RunningSession(const Places& places, const RunOptions& options)
        : places_(places), o_(options), log_(options.folder / "session.lcmlog"), recorder_(connection_, log_) {}

    RunOutcome run() {
        start_servo();
        if (o_.live) start_viewer();
        start_device();
        begin_ = Clock::now();
        follow();
        outcome_.wall_s = since_begin_s();
        outcome_.interrupted = interrupted();
        end();
        return outcome_;
    }

private:
    Child& start(const std::string& name, std::vector<std::string> command) {
        if (o_.no_realtime && name != "viewer" && name != "QEMU") command.push_back("--no-realtime");
        children_.push_back(std::make_unique<Child>(name, command));
        return *children_.back();
    }

    void start_servo() {
        if (!places_.image.empty()) return start_target();
        servo_ = &start("servo",
                        {(places_.scene / "servo").string(), "--lcm", "--csv", in(o_.folder, "servo.csv"), "--json"});
    }

    void start_target() {
        const std::string to = in(o_.folder, "to-target"), from = in(o_.folder, "from-target");
        for (const std::string& pipe : {to, from})
            if (mkfifo(pipe.c_str(), 0600) != 0) throw Error(pipe + ": no named pipe: " + std::strerror(errno));
        start("QEMU", {"env", "QEMU_SECONDS=0", "sh", "scripts/qemu.sh", o_.target, places_.image.string(), to, from});
        servo_ = &start("bridge", {(places_.programs / "haptable-bridge").string(), places_.scene.string(), "--pipes",
                                   to, from, "--csv", in(o_.folder, "servo.csv"), "--json"});
    }

    /// And waits until it listens, so that a short session has pictures too.
    void start_viewer() {
        Child& viewer =
            start("viewer", {(places_.programs / "haptable-view").string(), places_.scene.string(), "--lcm", "--every",
                             std::to_string(o_.every_ms), "-o", in(o_.folder, "pictures"), "--json"});
        const Clock::time_point give_up = Clock::now() + kPatience;
        while (viewer.last_words().empty() && !viewer.has_ended() && !interrupted() && Clock::now() < give_up)
            viewer.wait_some(kFlush);
    }

    void start_device() {
        std::vector<std::string> command{(places_.programs / "haptable-device").string(), o_.scene_file.string()};
        command.insert(command.end(), o_.device.begin(), o_.device.end());
        command.insert(command.end(), {"--csv", in(o_.folder, "device.csv"), "--json"});
        device_ = &start("device", std::move(command));
    }

    /// Until something ends it.
    void follow() {
        Clock::time_point next_line = begin_ + kLine, next_flush = begin_ + kFlush;
        for (int second = 1; !is_over();) {
            wait_until(std::min(next_line, next_flush));
            if (Clock::now() >= next_flush) flush(next_flush);
            if (Clock::now() < next_line) continue;
            if (!o_.quiet) fmt::print(stderr, "{:4} s  {}\n", second, recorder_.line());
            ++second;
            next_line += kLine;
        }
    }

    void flush(Clock::time_point& next) {
        log_.flush();
        next = Clock::now() + kFlush;
    }

    bool is_over() const {
        const auto has_ended = [](const auto& child) { return child->has_ended(); };
        return interrupted() || log_.failed() || std::any_of(children_.begin(), children_.end(), has_ended);
    }

    /// Messages, words and ends of programs until then, or until one program has ended.
    void wait_until(Clock::time_point deadline) {
        std::vector<pollfd> from{pollfd{connection_.fd(), POLLIN, 0}};
        for (const auto& child : children_)
            for (const int fd : child->fds()) from.push_back({fd, POLLIN, 0});
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
        ::poll(from.data(), from.size(), static_cast<int>(std::max<std::int64_t>(left.count() + 1, 0)));
        while (connection_.handle_until(Clock::now()) && Clock::now() < deadline) {
        }
        for (const auto& child : children_) {
            child->look();
            if (child->name() != "QEMU") hear(*child);
        }
    }

    /// What it tells its user. The last words of one that failed are told as the session's end.
    void hear(Child& child) {
        const std::string end = child.has_ended() && !child.is_well() ? child.last_words() : std::string();
        for (std::string& line : child.new_lines()) {
            if (line == end) continue;
            if (!o_.quiet) fmt::print(stderr, "{:4.1f} s  {}\n", since_begin_s(), line);
            if (outcome_.events.size() < kMostEvents)
                outcome_.events.push_back({since_begin_s(), std::move(line)});
            else
                ++outcome_.more_events;
        }
    }

    double since_begin_s() const { return std::chrono::duration<double>(Clock::now() - begin_).count(); }

    /// Last to first: who answers ends after who asks, so that each tells of a whole session.
    void end() {
        outcome_.trouble = trouble();
        for (auto child = children_.rbegin(); child != children_.rend(); ++child) end(**child);
        outcome_.device_summary = device_->out();
        outcome_.servo_summary = servo_->out();
        wait_until(Clock::now() + kFlush);
        for (const char* pipe : {"to-target", "from-target"}) std::filesystem::remove(o_.folder / pipe);
        try {
            log_.finish();
        } catch (const Error& error) {
            if (outcome_.trouble.empty()) outcome_.trouble = error.what();
        }
    }

    void end(Child& child) {
        child.ask_to_end();
        const Clock::time_point give_up = Clock::now() + kPatience;
        while (!child.has_ended() && Clock::now() < give_up) wait_until(Clock::now() + kFlush);
        child.wait(std::chrono::milliseconds(0));
        // QEMU ends by our signal alone.
        if (outcome_.trouble.empty() && !child.is_well() && child.name() != "QEMU")
            outcome_.trouble = child.how_it_ended();
    }

    /// What ended the session before the device's own end.
    std::string trouble() const {
        for (const auto& child : children_)
            if (child->has_ended() && (child.get() != device_ || !child->is_well())) return child->how_it_ended();
        if (log_.failed()) return in(o_.folder, "session.lcmlog") + ": cannot be written further: is the disk full?";
        return {};
    }

    const Places& places_;
    const RunOptions& o_;
    Connection connection_;
    LogWriter log_;
    Recorder recorder_;
    RunOutcome outcome_;
    Clock::time_point begin_ = Clock::now();
    std::vector<std::unique_ptr<Child>> children_;  ///< in the order of their starts
    Child* servo_ = nullptr;                        ///< or the bridge
    Child* device_ = nullptr;
};

}  // namespace

RunOutcome run_session(const Places& places, const RunOptions& options) {
    return RunningSession(places, options).run();
}

}  // namespace haptable
