// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-view: draws the deformed body from a servo's CSV, an LCM log, or live.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/program.hpp"
#include "host/base/progress.hpp"
#include "host/base/summary_lines.hpp"
#include "host/page/live/live.hpp"
#include "host/page/page.hpp"
#include "host/view/contact_messages.hpp"
#include "host/view/figure.hpp"
#include "host/view/output.hpp"
#include "host/view/painter.hpp"
#include "host/view/servo_csv.hpp"
#include "host/view/vtu.hpp"

namespace {

using namespace haptable;
namespace fs = std::filesystem;

struct Options {
    fs::path folder, out, csv, log, page;
    bool lcm = false, mesh = false, sag = false, vtu = false, json = false, quiet = false, serve = false;
    LiveOptions live;
    FrameChoice choice;
    LiveLimits limits;
    ViewOptions view;
    std::string size = "960x720";
    double range = 0.0;  ///< mm, mN or kPa
    double fps = 0.0;    ///< 0: real time
    double page_mb = 1e-6 * kPageBytes;
    int samples = 0;            ///< 0: as fits the source
    std::int64_t every_ms = 0;  ///< 0: as --fps wants
};

void add_options(CommandLine& app, Options& o) {
    app.option("DIR", o.folder, "folder that haptable-precompute wrote").required();
    ExclusiveOptions source = app.exclusive("source", "what is drawn");
    source.option("--csv", o.csv, "a servo's CSV (servo --replay IN --out FILE)");
    source.option("--log", o.log, "an LCM log (lcm-logger FILE)");
    const Option lcm = source.flag("--lcm", o.lcm, "live, until Ctrl-C, --frames or --seconds");
    source.flag("--mesh", o.mesh, "the rest shape alone");
    source.flag("--sag", o.sag, "the body under its own weight ([gravity] of its scene), from its shape without");
    const Option page = source.option("--page", o.page, "write one HTML file that lets a pointer touch the body");
    const Option serve = app.flag("--serve", o.serve,
                                  "with --lcm: that page over the live session, for browsers of this machine alone, at "
                                  "an address with a token, which is printed");
    serve.needs(lcm);
    app.flag("--touch", o.live.touch, "with --serve: the pointer of the first page is a device of the session")
        .needs(serve);
    app.option("--port", o.live.port, "of --serve [any that is free]").range(1, 65535).needs(serve);
    app.option("-o,--out", o.out, "a folder for PNGs, one .png, .svg or .pdf, or a film: .mp4 or .gif")
        .excludes(page)
        .excludes(serve);
    app.option("--megabytes", o.page_mb, "of a page, at the most").positive().show_default();
    app.option("--every", o.every_ms, "ticks (milliseconds) from picture to picture [33, or as --fps wants]")
        .range(1, 1000000);
    app.option("--fps", o.fps, "pictures a second of a film [real time]; with --every it plays slower or faster")
        .positive();
    app.option("--ticks", o.choice.ticks, "only these ticks (of a log: these seq), as A,B,C").delimiter(',');
    app.option("--frames", o.limits.frames, "live: end after so many pictures").positive().needs(lcm);
    app.option("--seconds", o.limits.seconds, "live: end after so many seconds").positive().needs(lcm);
    app.option("--size", o.size, "of the picture, in pixels").show_default();
    app.option("--samples", o.samples,
               "of a pixel: 4, or 1 with outlines smoothed afterwards, faster [4, of films and live 1]")
        .one_of({1, 4});
    app.option("--azimuth", o.view.azimuth, "of the eye, degrees from +x towards +y").show_default();
    app.option("--elevation", o.view.elevation, "of the eye above the xy plane, degrees")
        .range(-89.9, 89.9)
        .show_default();
    app.option("--zoom", o.view.zoom, "1 shows the whole body").range(0.05, 50.0).show_default();
    app.option("--up", o.view.up, "the body's axis that points up: x y z -x -y -z").show_default();
    app.option("--color", o.view.color,
               "what the colours show: displacement, force (of the nodes), or stress (von Mises, of the surface's "
               "elements; needs columns = \"all\")")
        .show_default();
    app.option("--range", o.range, "end of the colour scale, mm, mN or kPa [the largest value]").positive();
    app.option("--exaggerate", o.view.exaggeration, "draw displacements so many times as large; the caption says so")
        .positive()
        .show_default();
    app.flag("--ghost", o.view.ghost, "the rest shape too, half transparent");
    app.flag("--vtu", o.vtu, "also write the deformed surfaces for ParaView: frame_*.vtu and frames.pvd");
    app.flag("--json", o.json, "print the summary as JSON");
    app.flag("--quiet", o.quiet, "no progress bar and no summary");
}

void parse_size(const std::string& text, ViewOptions& view) {
    int used = 0;
    constexpr int kLeast = 160, kMost = 8192;
    if (std::sscanf(text.c_str(), "%dx%d%n", &view.width, &view.height, &used) != 2 ||
        static_cast<std::size_t>(used) != text.size() || std::min(view.width, view.height) < kLeast ||
        std::max(view.width, view.height) > kMost)
        throw BadCommandLine("--size " + text + ": give WIDTHxHEIGHT, each from 160 to 8192, as in 960x720");
}

/// Counts, times and extremes of a run.
struct Report {
    std::int64_t frames = 0;
    std::int64_t left_out_messages = 0;  ///< damaged, of other tables or of a second servo
    double first_draw_ms = 0.0, draw_ms = 0.0, write_ms = 0.0;
    Ranges largest;
};

double since_ms(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

double frame_ms(const Options& options) { return 1e3 / options.fps; }

/// Draws frames one by one and hands them to the output.
class Session {
public:
    Session(const Options& options, const Tables& tables)
        : options_(options), painter_(tables, options.folder, options.view, !options.mesh) {
        open();
    }
    Session(const Options& options, const Sag& sag) : options_(options), painter_(sag, options.folder, options.view) {
        open();
    }

    void widen(const ContactFrame& frame) { painter_.measure(frame, report.largest); }

    void add(const ContactFrame& frame) {
        Ranges ranges = report.largest;
        if (options_.range > 0.0) {
            ranges.displacement_m = ranges.nodal_force_n = 1e-3 * options_.range;
            ranges.stress_pa = 1e3 * options_.range;
        }
        if (output_)
            finish([&]() -> const Image& { return painter_.paint(frame, ranges); });
        else
            painter_.figure(frame, ranges, options_.out), ++report.frames;
        if (vtu_) add_vtu(frame);
    }

    void add_mesh() {
        if (output_)
            finish([&]() -> const Image& { return painter_.paint_mesh(); });
        else
            painter_.figure_mesh(options_.out), ++report.frames;
        if (vtu_) add_vtu({});
    }

    void close() {
        if (vtu_) vtu_->close();
        if (output_) output_->close();
    }

    Report report;

private:
    void open() {
        if (!is_figure(options_.out))
            output_.emplace(options_.out, options_.view.width, options_.view.height, frame_ms(options_));
        if (!options_.vtu) return;
        if (!output_ || output_->folder() == nullptr)
            throw BadCommandLine("--vtu: give a folder with -o, not " + options_.out.string());
        vtu_.emplace(*output_->folder());
    }

    void add_vtu(const ContactFrame& frame) { vtu_->add(painter_.surface(), frame); }

    template <typename Paint>
    void finish(const Paint& paint) {
        const auto begin = std::chrono::steady_clock::now();
        const Image& image = paint();
        const double draw_ms = since_ms(begin);
        const auto painted = std::chrono::steady_clock::now();
        output_->add(image);
        report.write_ms += since_ms(painted);
        // The first frame waits for Mesa to compile the shaders.
        (report.frames++ == 0 ? report.first_draw_ms : report.draw_ms) += draw_ms;
    }

    const Options& options_;
    Painter painter_;
    std::optional<Output> output_;
    std::optional<VtuSeries> vtu_;
};

RecordedContacts read_frames(const Options& options, const Tables& tables) {
    const ContactLoads loads(tables);
    RecordedContacts recorded = options.csv.empty()
                                    ? read_contact_log(options.log, loads, options.choice)
                                    : RecordedContacts{read_servo_csv(options.csv, loads, options.choice), 0};
    if ((options.out.extension() == ".png" || is_figure(options.out)) && recorded.frames.size() > 1)
        throw Error(fmt::format("{}: holds one picture, but {} were chosen: give a folder, or one tick with --ticks",
                                options.out.string(), recorded.frames.size()));
    return recorded;
}

Report draw_recorded(const Options& options, const Tables& tables) {
    const RecordedContacts recorded = read_frames(options, tables);
    const std::vector<ContactFrame>& frames = recorded.frames;
    catch_interrupts();
    Session session(options, tables);
    Progress progress(options.quiet);
    progress.stage("draw");
    for (const ContactFrame& frame : frames) session.widen(frame);
    for (std::size_t i = 0; i < frames.size(); ++i) {
        stop_if_interrupted();
        session.add(frames[i]);
        progress.done(static_cast<double>(i + 1) / static_cast<double>(frames.size()));
    }
    session.close();
    session.report.left_out_messages = recorded.left_out;
    return session.report;
}

Report draw_live(const Options& given, const Tables& tables) {
    Options options = given;
    if (options.out.extension() == ".png" || is_figure(options.out)) options.limits.frames = 1;
    catch_interrupts();  // Ctrl-C is the usual end
    Session session(options, tables);
    const ContactLoads loads(tables);
    const auto draw = [&](const ContactFrame& frame) {
        session.widen(frame);
        session.add(frame);
    };
    const LiveState live(teller("haptable-view", options.quiet));
    const FollowedContacts followed = follow_contacts(
        loads, options.limits, draw, [&](const std::string& url) { live.say("draws what comes on " + url); });
    session.close();
    session.report.left_out_messages = followed.left_out;
    return session.report;
}

Report draw_mesh(const Options& options, const Tables& tables) {
    Session session(options, tables);
    session.add_mesh();
    session.close();
    return session.report;
}

Report draw_sag(const Options& options, const Tables& tables) {
    const Sag sag = read_sag(tables, options.folder);
    Session session(options, sag);
    session.widen({});
    session.add({});
    session.close();
    return session.report;
}

void print(const Report& report, const Options& options) {
    const auto later = static_cast<double>(std::max<std::int64_t>(report.frames - 1, 1));
    SummaryLines summary;
    summary.add("frames", report.frames);
    summary.add("left_out_messages", report.left_out_messages);
    summary.add("largest_displacement_mm", 1e3 * report.largest.displacement_m);
    summary.add("largest_force_n", report.largest.force_n);
    summary.add("first_draw_ms", report.first_draw_ms);
    summary.add("draw_ms_per_frame", report.draw_ms / later);
    summary.add("write_ms_per_frame", report.write_ms / static_cast<double>(std::max<std::int64_t>(report.frames, 1)));
    summary.add("out", options.out.string());
    summary.print(options.json, options.quiet);
}

void make_page(const Options& options) {
    const PageReport report = write_page(options.folder, page_parts(), options.page, 1e6 * options.page_mb);
    SummaryLines summary;
    summary.add("page", options.page.string());
    summary.add("megabytes", 1e-6 * static_cast<double>(report.bytes));
    summary.add("columns", report.columns);
    summary.add("column_error", report.column_error);
    summary.add("modes", fmt::format("{}", fmt::join(report.modes, ", ")));
    summary.print(options.json, options.quiet);
}

void serve(Options& o) {
    catch_interrupts();
    o.live.seconds = o.limits.seconds;
    o.live.most_bytes = 1e6 * o.page_mb;
    o.live.tell = teller("haptable-view", o.quiet);
    // What everything else here is for: --quiet and --json are of the summary.
    o.live.show = [](const std::string& url) {
        fmt::print("{}\n", url);
        std::fflush(stdout);
    };
    const LiveReport report = serve_session(o.folder, o.live);
    SummaryLines summary;
    summary.add("pages", report.pages);
    summary.add("ticks", report.ticks);
    summary.add("lost_ticks", report.lost_ticks);
    summary.add("other_tables_messages", report.left_out.other_tables);
    summary.add("other_servo_messages", report.left_out.other_servo);
    summary.add("damaged_messages", report.left_out.damaged);
    summary.add("pointer_sessions", report.pointer_sessions);
    summary.add("pointer_ticks", report.pointer_ticks);
    summary.print(o.json, o.quiet);
}

void complete(Options& o) {
    parse_size(o.size, o.view);
    const bool film = is_film(o.out);
    o.view.samples = o.samples != 0 ? o.samples : o.lcm || film ? 1 : 4;
    if (o.view.color != "displacement" && o.view.color != "force" && o.view.color != "stress")
        throw BadCommandLine("--color " + o.view.color + ": give displacement, force or stress");
    constexpr std::int64_t kEvery_ms = 33;
    if (o.fps > 0.0 && !film)
        throw BadCommandLine("--fps: is of films, and " + o.out.string() + " is none: give .mp4 or .gif");
    const bool slowed = o.fps > 0.0 && o.every_ms > 0;
    if (o.every_ms == 0) o.every_ms = o.fps > 0.0 ? std::max<std::int64_t>(std::lround(1e3 / o.fps), 1) : kEvery_ms;
    o.choice.every_ms = o.limits.every_ms = o.every_ms;
    if (!slowed) o.fps = 1e3 / static_cast<double>(o.every_ms);
    if (film) o.view.speed = 1e-3 * static_cast<double>(o.every_ms) * o.fps;
}

void view(Options& options) {
    if (options.serve) return serve(options);
    if (!options.page.empty()) return make_page(options);
    if (options.out.empty()) throw BadCommandLine("--out is required");
    complete(options);
    const Tables tables = read_tables(options.folder);
    const auto draw = options.lcm ? draw_live : options.mesh ? draw_mesh : options.sag ? draw_sag : draw_recorded;
    print(draw(options, tables), options);
}

}  // namespace

int main(int argc, char** argv) {
    CommandLine app("Draws the deformed body: from a servo's CSV, from an LCM log, or live over LCM.", "haptable-view");
    Options options;
    add_options(app, options);
    return run_program(app, argc, argv, [&options] { view(options); });
}
