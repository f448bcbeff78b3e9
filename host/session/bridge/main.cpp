// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-bridge: a microcontroller behind a serial line as the servo of a device over LCM.
#include <fmt/format.h>
#include <poll.h>

#include <cmath>
#include <csignal>
#include <optional>
#include <string>
#include <vector>

#include "codegen/loaded_scene.hpp"
#include "host/base/error.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/program.hpp"
#include "host/base/summary_lines.hpp"
#include "host/link/realtime.hpp"
#include "host/session/bridge/line_stepper.hpp"
#include "host/session/serve.hpp"

namespace haptable {

namespace {

constexpr int kPriority = 50;  // as the servo's: it stands for it

struct Options {
    std::string folder, port, program, csv;
    std::vector<std::string> pipes;
    unsigned baud = 1'000'000;
    double retry_ms = 50.0;
    SessionEnd end;
    LineOptions line;
    bool no_realtime = false, json = false, quiet = false;
};

void add_options(CommandLine& app, Options& o) {
    app.option("DIR", o.folder, "folder of the scene that the target was built for: build/cube").required();
    ExclusiveOptions line = app.exclusive("line", "where the target is, one of:");
    line.option("--port", o.port, "a serial port (/dev/ttyACM0), a pty or a Unix socket");
    line.option("--pipes", o.pipes, "two named pipes, TO the target and FROM it").count(2).values_name("TO FROM");
    line.option("--run", o.program, "a program whose standard input and output are the line, like QEMU");
    app.option("--baud", o.baud, "bits a second of a serial port").show_default();
    app.option("--retry", o.retry_ms, "ms, after which a state is sent again").positive().show_default();
    app.option("--patience", o.line.patience_s, "s without any answer, after which the target is gone")
        .positive()
        .show_default();
    app.option("--csv", o.csv, "record the session here, as the servo's --csv does");
    app.option("--seconds", o.end.after_s, "end after this time").positive();
    app.option("--until-silent", o.end.until_silent_s, "end when the device was silent for this many seconds")
        .positive();
    app.flag("--no-realtime", o.no_realtime, "do not ask for real-time priority");
    app.flag("--json", o.json, "print the summary as JSON");
    app.flag("--quiet", o.quiet, "print nothing but errors (and what --json asks for)");
}

/// As the target has it.
ServoScene servo_of(const LoadedScene& scene) {
    return {&scene.model(), scene.node().data(), scene.tables().name.c_str(), scene.pair(), scene.modes(),
            scene.body(),   scene.tool()};
}

Line open_line(const Options& o) {
    if (!o.port.empty()) return Line::open(o.port, o.baud);
    if (!o.pipes.empty()) return Line::pipes(o.pipes[0], o.pipes[1]);
    return Line::program(o.program);
}

/// Until a message, a byte of the line or the deadline.
void wait_for_either(const Connection& connection, const SerialTarget& target, Clock::time_point deadline) {
    std::array<pollfd, 2> from{pollfd{connection.fd(), POLLIN, 0}, pollfd{target.line().fd(), POLLIN, 0}};
    const auto ns =
        std::chrono::duration_cast<std::chrono::nanoseconds>(std::max(deadline - Clock::now(), Clock::duration::zero()))
            .count();
    const timespec left{ns / 1'000'000'000, ns % 1'000'000'000};
    ppoll(from.data(), from.size(), &left, nullptr);
}

/// What comes from either until then: answers first, for the device waits for them.
void handle(Session& session, Connection& connection, const SerialTarget& target, Clock::time_point deadline) {
    wait_for_either(connection, target, deadline);
    session.take_answers();
    while (connection.handle_until(Clock::now())) session.take_answers();
}

SummaryLines summarise(const Session& session, const LineStepper& stepper, const SerialTarget& target,
                       const std::string& url) {
    SummaryLines summary;
    summary.add("scene", std::string(target.scene().name));
    summary.add("tables_hash", fmt::format("{:016x}", target.scene().model->hash));
    summary.add("url", url);
    summary.add("line", target.line().name());
    for (std::size_t finger = 0; finger < stepper.finger_count(); ++finger) {
        const std::string suffix = kFingerSuffix[finger];
        add_link_report(session.link_report(finger), suffix, summary);
        stepper.count(finger, [&](const char* name, std::int64_t value) { summary.add(name + suffix, value); });
        stepper.forces(finger).add_to(summary, suffix);
    }
    if (stepper.finger_count() == 2) summary.add("energy_most_given_to_both_j", stepper.most_given_j());
    const DurationStatistics& round_trip = stepper.round_trip();
    summary.add("round_trip_mean_us", round_trip.mean_us());
    summary.add("round_trip_p999_us", round_trip.quantile_us(0.999));
    summary.add("round_trip_max_us", round_trip.max_us());
    return summary;
}

void run(Options& o) {
    catch_interrupts();
    std::signal(SIGPIPE, SIG_IGN);  // a line that ends is an error with a name, not the end of this program
    o.line.retry = std::chrono::microseconds(std::llround(o.retry_ms * 1000.0));
    const LoadedScene scene{TablesFolder(o.folder)};
    const ServoScene servo = servo_of(scene);
    const std::string priority = o.no_realtime ? "normal priority" : ask_for_real_time(kPriority);
    std::optional<ServoRecord> record;
    if (!o.csv.empty()) record.emplace(servo, o.csv).keep();
    SerialTarget target(open_line(o), servo);
    Connection connection;
    LineStepper stepper(target, o.line);
    Session session(stepper, connection, record ? &*record : nullptr, teller("haptable-bridge", o.quiet));
    if (!o.quiet)
        fmt::print(stderr, "haptable-bridge: {} on {}, {}, {}\n", scene.tables().name, connection.url(),
                   target.line().name(), priority);
    serve(session, o.end, [&](Clock::time_point deadline) { handle(session, connection, target, deadline); });
    if (record) record->finish();
    summarise(session, stepper, target, connection.url()).print(o.json, o.quiet);
}

}  // namespace

}  // namespace haptable

int main(int argc, char** argv) {
    haptable::CommandLine app("A microcontroller behind a serial line, as the servo of a device over LCM.",
                              "haptable-bridge");
    haptable::Options options;
    haptable::add_options(app, options);
    return haptable::run_program(app, argc, argv, [&] { haptable::run(options); });
}
