// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-bench-realtime: a session in real time beside one with a servo that does nothing, on a quiet machine and on
// a busy one: what the loop adds to what LCM and the kernel take.
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "host/base/child.hpp"
#include "host/base/error.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/program.hpp"
#include "host/base/progress.hpp"
#include "host/link/connection.hpp"
#include "host/link/messages.hpp"
#include "host/link/realtime.hpp"
#include "host/link/statistics.hpp"
#include "host/numbers/numbers.hpp"
#include "host/scene/scene.hpp"

namespace haptable {

namespace {

using Json = nlohmann::json;

struct Options {
    std::filesystem::path scene_file, build = "build", out;
    double seconds = 60.0;
    bool echo = false, quiet = false;
};

/// A servo that answers every state at once, and with nothing.
void echo() {
    catch_interrupts();
    ask_for_real_time(50);  // as the servo
    Connection connection;
    servo_force answer{};
    answer.servo = random_session();
    answer.servo_state = servo_force::FREE;
    connection.subscribe<device_state>(channel_of<device_state>(), [&](const device_state& state, std::int64_t) {
        answer.utime = utime_now();
        answer.seq = state.seq;
        answer.session = answer.owner = state.session;
        connection.publish(channel_of<servo_force>(), answer);
    });
    while (!interrupted()) connection.handle_until(Clock::now() + std::chrono::milliseconds(100));
}

/// As many programs that never rest as there are processors. Niced: who asks for real time does not feel the
/// difference, and others on this machine do.
std::vector<std::unique_ptr<Child>> load() {
    std::vector<std::unique_ptr<Child>> programs;
    for (unsigned i = 0; i < std::thread::hardware_concurrency(); ++i)
        programs.push_back(std::make_unique<Child>(
            "load", std::vector<std::string>{"nice", "-n", "19", "sh", "-c", "while :; do :; done"}));
    return programs;
}

/// When states and answers were on the wire, by the kernel's clock, whenever this program came to read them.
class Wire {
public:
    explicit Wire(Connection& connection) {
        connection.subscribe<device_state>(
            channel_of<device_state>(),
            [this](const device_state& state, std::int64_t utime) { note(state.seq, utime, sent_); });
        connection.subscribe<servo_force>(channel_of<servo_force>(),
                                          [this](const servo_force& force, std::int64_t utime) {
                                              if (force.owner == force.session) note(force.seq, utime, answered_);
                                          });
    }

    struct Times {
        DurationStatistics period, latency, age;
        std::int64_t unheard = 0;  ///< states that this program missed
    };
    /// Age: when a state is sent, how long ago that one was sent which the newest answer until then belongs to.
    Times times() const {
        Times times;
        std::size_t newest = kBegun_ticks - 1;  // state whose answer acts
        for (std::size_t k = kBegun_ticks; k < sent_.size(); ++k) {
            if (sent_[k] == 0 || sent_[k - 1] == 0) {
                ++times.unheard;
                continue;
            }
            times.period.add(static_cast<double>(sent_[k] - sent_[k - 1]));
            if (k < answered_.size() && answered_[k] != 0)
                times.latency.add(static_cast<double>(answered_[k] - sent_[k]));
            for (std::size_t j = k - 1; j > newest; --j)
                if (j < answered_.size() && answered_[j] != 0 && answered_[j] <= sent_[k]) newest = j;
            if (sent_[newest] != 0) times.age.add(static_cast<double>(sent_[k] - sent_[newest]));
        }
        return times;
    }

private:
    // The first state waits for the servo's start.
    static constexpr std::size_t kBegun_ticks = 100;

    static void note(std::int64_t seq, std::int64_t utime, std::vector<std::int64_t>& times) {
        const auto place = static_cast<std::size_t>(seq);
        if (seq < 0 || place > 100'000'000) return;
        if (place >= times.size()) times.resize(place + 1);
        if (times[place] == 0) times[place] = utime;
    }

    std::vector<std::int64_t> sent_, answered_;  ///< by seq, us; 0: not heard
};

/// Time of the machine's processors, s.
struct ProcessorTime {
    double all = 0.0, busy = 0.0;  ///< busy: not idle; a virtual machine's stolen time too
    double ours = 0.0;             ///< of this program, and of those that it started and that have ended
};

ProcessorTime processor_time() {
    std::ifstream stat("/proc/stat");
    std::string cpu;
    ProcessorTime time;
    const auto tick_s = 1.0 / static_cast<double>(sysconf(_SC_CLK_TCK));
    stat >> cpu;
    for (int column = 0; column < 8; ++column) {  // user nice system idle iowait irq softirq steal
        double ticks = 0.0;
        stat >> ticks;
        time.all += ticks * tick_s;
        if (column != 3 && column != 4) time.busy += ticks * tick_s;
    }
    for (const auto who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
        rusage used{};
        getrusage(who, &used);
        for (const timeval& part : {used.ru_utime, used.ru_stime})
            time.ours += static_cast<double>(part.tv_sec) + 1e-6 * static_cast<double>(part.tv_usec);
    }
    return time;
}

/// The share of the processors' time that other programs took.
double others_share(const ProcessorTime& before, const ProcessorTime& after) {
    const double others = after.busy - before.busy - (after.ours - before.ours);
    return std::clamp(others / std::max(after.all - before.all, 1e-3), 0.0, 1.0);
}

struct Measured {
    Wire::Times times;
    Json device;
    double others_share = 0.0;
};

/// A session with that partner.
Measured session_with(const std::vector<std::string>& partner, const Options& o, Progress& progress, double begun) {
    Connection connection;
    const Wire wire(connection);
    const ProcessorTime before = processor_time();
    Child servo("servo", partner);
    Child device("device", {(o.build / "bin/haptable-device").string(), o.scene_file.string(), "--path",
                            "poke,drag,circle", "--seconds", fmt::format("{}", o.seconds), "--json", "--quiet"});
    const auto begin = Clock::now();
    while (!device.has_ended()) {
        connection.handle_until(Clock::now() + std::chrono::milliseconds(20));
        device.look();
        servo.look();
        if (servo.has_ended()) throw Error(servo.how_it_ended());
        progress.done(begun + 0.25 * std::chrono::duration<double>(Clock::now() - begin).count() / o.seconds);
    }
    servo.ask_to_end();
    servo.wait(std::chrono::seconds(10));
    if (!device.is_well()) throw Error(device.how_it_ended());
    return {wire.times(), Json::parse(device.out()), others_share(before, processor_time())};
}

constexpr std::array kQuantities{std::pair{&Wire::Times::period, "from state to state"},
                                 std::pair{&Wire::Times::latency, "from state to answer"},
                                 std::pair{&Wire::Times::age, "age of the force"}};

std::array<double, 4> shares_of(const DurationStatistics& us) {
    return {us.quantile_us(0.5), us.quantile_us(0.99), us.quantile_us(0.999), us.max_us()};
}

Number microseconds(double us) { return number(1e-6 * us, fmt::format("{:.0f} us", us)); }

void add_rows(const std::string& machine, const Measured& servo, const Measured& nothing, NumberTable& table) {
    for (const auto& [quantity, words] : kQuantities) {
        std::vector<Cell> of_servo{machine, words, "servo"}, of_echo{machine, words, "echo"},
            ratio{machine, words, "ratio"};
        const auto a = shares_of(servo.times.*quantity), b = shares_of(nothing.times.*quantity);
        for (std::size_t share = 0; share < a.size(); ++share) {
            of_servo.emplace_back(microseconds(a[share]));
            of_echo.emplace_back(microseconds(b[share]));
            ratio.emplace_back(number(a[share] / b[share], fmt::format("{:.2f}", a[share] / b[share])));
        }
        for (auto* row : {&of_servo, &of_echo, &ratio}) table.rows.push_back(std::move(*row));
    }
}

void add_counts(const std::string& machine, const char* partner, const Measured& measured, NumberTable& table) {
    std::vector<Cell> row{machine, partner};
    for (const char* counter : {"ticks", "missed", "late_ticks", "silences"})
        row.emplace_back(count(measured.device.at(counter).get<std::uint64_t>()));
    row.emplace_back(count(static_cast<std::uint64_t>(measured.times.unheard)));
    row.emplace_back(number(measured.others_share, fmt::format("{:.0f} %", 100.0 * measured.others_share)));
    table.rows.push_back(std::move(row));
}

void measure(const Options& o, const std::string& program) {
    catch_interrupts();
    const std::string name = read_scene(o.scene_file).name;
    const std::vector<std::string> servo{(o.build / name / "servo").string(), "--lcm", "--quiet"},
        nothing{program, "--echo"};
    Progress progress(o.quiet);
    progress.stage("real time");
    NumberTable times{{"machine", "what", "with", "median", "99 %", "99.9 %", "worst"}, {}},
        counts{{"machine", "with", "ticks", "without an answer in time", "begun more than 1 ms late", "silences",
                "not heard by the bench", "processors' time that others took"},
               {}};
    double begun = 0.0;
    for (const char* machine : {"quiet", "busy"}) {
        const auto programs = std::string(machine) == "busy" ? load() : std::vector<std::unique_ptr<Child>>{};
        const Measured with_echo = session_with(nothing, o, progress, begun);
        const Measured with_servo = session_with(servo, o, progress, begun + 0.25);
        begun += 0.5;
        add_rows(machine, with_servo, with_echo, times);
        add_counts(machine, "servo", with_servo, counts);
        add_counts(machine, "echo", with_echo, counts);
    }
    progress.clear();
    Numbers numbers("make bench-realtime");
    numbers.add("realtime", times);
    numbers.add("realtime-counts", counts);
    if (!o.quiet) print_topics(numbers);
    if (!o.out.empty()) numbers.write(o.out);
}

}  // namespace

}  // namespace haptable

int main(int argc, char** argv) {
    haptable::CommandLine app("A session in real time beside one whose servo does nothing.", "haptable-bench-realtime");
    haptable::Options o;
    const haptable::Option scene = app.option("SCENE", o.scene_file, "the scene file; its servo must be there");
    app.option("--build", o.build, "folder of programs and servo").show_default();
    app.option("--seconds", o.seconds, "of each of the four sessions").positive().show_default();
    app.option("-o", o.out, "write the numbers to this JSON file");
    app.flag("--echo", o.echo, "be the servo that does nothing").excludes(scene);
    app.flag("--quiet", o.quiet, "print nothing but errors");
    return haptable::run_program(app, argc, argv, [&] {
        if (o.echo) return haptable::echo();
        if (o.scene_file.empty()) throw haptable::Error("SCENE: give a scene file, as in meshes/cube.toml");
        haptable::measure(o, std::filesystem::read_symlink("/proc/self/exe"));
    });
}
