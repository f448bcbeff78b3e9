// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-precompute: mesh and material in, tables out.
#include <fmt/format.h>

#include <cctype>
#include <cstdio>
#include <string_view>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/own_folder.hpp"
#include "host/base/program.hpp"
#include "host/body/rigid_body.hpp"
#include "host/body/sample_tool.hpp"
#include "host/body/under_constrained.hpp"
#include "host/mesh/audit.hpp"
#include "host/mesh/read_mesh.hpp"
#include "host/precompute/check_page.hpp"
#include "host/precompute/facts.hpp"
#include "host/precompute/foretell.hpp"
#include "host/precompute/owner.hpp"
#include "host/precompute/requirements.hpp"
#include "host/precompute/tell.hpp"
#include "host/precompute/write_tables.hpp"
#include "host/tables/own_tables.hpp"

namespace {

using namespace haptable;
namespace fs = std::filesystem;

struct Options {
    fs::path scene;
    fs::path folder, build = "build";
    fs::path depfile;
    PrecomputeOptions how;
    Telling telling{"haptable-precompute"};
    bool print_name = false;
    bool check = false;
};

fs::path folder_of(const Options& options, const Scene& scene) {
    return options.folder.empty() ? options.build / scene.name : options.folder;
}

/// A path as make reads it. Throws Error for a character that make would take for another thing in any case.
std::string make_path(const fs::path& path) {
    constexpr std::string_view kPlain = "._-+@/~,", kEscaped = " #:";
    std::string escaped;
    for (const char c : path.string()) {
        const auto byte = static_cast<unsigned char>(c);
        const bool is_plain = byte >= 0x80 || std::isalnum(byte) != 0 || kPlain.find(c) != kPlain.npos;
        if (kEscaped.find(c) != kEscaped.npos)
            escaped += '\\';
        else if (c == '$')
            escaped += '$';
        else if (!is_plain)
            throw Error(
                fmt::format("--depfile: {}: make reads no name with \"{}\" in it: rename it", path.string(), c));
        escaped += c;
    }
    return escaped;
}

/// "DIR/summary.json: scene mesh", and each input as a target of its own, so that make survives its removal.
std::string dependencies(const Scene& scene, const fs::path& folder) {
    std::string inputs = " " + make_path(scene.file);
    std::string targets = "\n" + make_path(scene.file) + ":\n";
    std::vector<fs::path> files = mesh_files(scene.mesh.file);
    if (scene.tool && scene.tool->shape && !scene.tool->shape->file.empty())
        for (const fs::path& file : mesh_files(scene.tool->shape->file)) files.push_back(file);
    if (scene.material.stiffening && scene.material.stiffening->press)
        files.push_back(scene.material.stiffening->press->file);
    for (const fs::path& file : files) {
        if (file.empty()) continue;  // a generated mesh has none
        inputs += " " + make_path(file);
        targets += make_path(file) + ":\n";
    }
    return make_path(folder / "summary.json") + ":" + inputs + "\n" + targets;
}

void print_check(const Scene& scene, const Audit& audit, const std::vector<Support>& supports, const Options& options,
                 const std::optional<GravityFacts>& gravity = {}) {
    if (options.telling.json) {
        fmt::print("{}", to_json(audit, supports, gravity));
    } else if (!options.telling.quiet) {
        fmt::print("{}", to_table(audit));
        for (std::size_t k = 0; k < supports.size(); ++k)
            fmt::print("  body {}: {} nodes, {} tetrahedra; {} nodes fixed, {}{}\n", k + 1, supports[k].nodes,
                       supports[k].tets, supports[k].fixed_nodes,
                       supports[k].bed_faces > 0 ? fmt::format("{} faces on a bed, ", supports[k].bed_faces) : "",
                       scene.free_body              ? "free: nothing holds it"
                       : supports[k].is_constrained ? "constrained"
                                                    : "UNDER-CONSTRAINED");
    }
}

void draw_check(const Scene& scene, const Body& body, const Audit& audit,
                const std::vector<std::int32_t>& under_constrained, const Options& options) {
    const fs::path folder = folder_of(options, scene);
    try {
        OwnFolder own(folder, kTables, own_tables_in(folder));
        write_file(own.file("check.html"), check_page(scene, body, audit, under_constrained));
    } catch (const Error& error) {  // what was found is worth more than its picture
        return say(options.telling, "warning", {error.what()});
    }
    if (!options.telling.quiet && !options.telling.json)
        fmt::print("  drawn in {}\n", (folder / "check.html").string());
}

/// The mesh is judged, and of the body what one factorisation tells: the table first, then the first reason to refuse
/// it.
void check(const Scene& scene, const Options& options) {
    TetMesh mesh = make_mesh(scene.mesh);
    const Audit audit = audit_mesh(mesh);
    say(options.telling, "note", mesh.notes);
    if (Scene completed = scene; completed.tool) {
        const ToolSample tool = complete_tool(completed);
        say(options.telling, "note", {"the tool has " + describe_tool(completed, tool)});
    }
    say(options.telling, "warning", warnings_of(audit, scene.mesh.scale_m));
    std::vector<std::int32_t> under_constrained;
    Body body;
    try {
        body = make_body(scene, std::move(mesh));
        if (scene.free_body)
            require_one_body(scene, body);
        else
            under_constrained = find_under_constrained(body);
    } catch (const Error&) {
        print_check(scene, audit, {}, options);
        throw;
    }
    say(options.telling, "warning", holding_warnings(scene, body));
    draw_check(scene, body, audit, under_constrained, options);
    Foretold told;
    try {
        Progress progress(options.telling.quiet);
        if (under_constrained.empty()) told = foretell(scene, body, progress);
    } catch (const Error&) {
        print_check(scene, audit, find_supports(body, under_constrained), options);
        throw;
    }
    say(options.telling, "warning", locking_warnings(scene, told.locking));
    say(options.telling, "warning", gravity_warnings(scene, told.gravity, audit.box_m));
    print_check(scene, audit, find_supports(body, under_constrained), options, told.gravity);
    if (told.gravity && !options.telling.json && !options.telling.quiet)
        fmt::print("{}", describe(scene, *told.gravity));
    if (told.gravity && scene.gravity->prestress) require_unbuckled(scene, *told.gravity);
    if (!under_constrained.empty())
        throw Error(
            fmt::format("{}: fixed: {}", scene.file.string(), describe_under_constrained(under_constrained, body)));
    if (scene.free_body) require_movable(scene, rigid_body_of(scene, body));
    require_rows_and_modes(scene, body);
    require_servo(scene, body);
}

/// Ctrl-C among the columns leaves what is done of them: says so.
Result compute(const Scene& scene, const fs::path& folder, Progress& progress, const PrecomputeOptions& how) try {
    return precompute(scene, folder, progress, how);
} catch (const Interrupted&) {
    progress.clear();
    if (fs::exists(work_folder(folder)))
        fmt::print(stderr, "haptable-precompute: finished columns are kept in {}: start again to go on from there\n",
                   work_folder(folder).string());
    throw;
}

void run(const Options& options) {
    // 1. The scene.
    const Scene scene = read_scene(options.scene);
    if (options.print_name) {
        fmt::print("{}\n", scene.name);
        return;
    }
    if (options.check) return check(scene, options);
    const fs::path folder = folder_of(options, scene);
    if (options.folder.empty()) require_own(folder, scene);
    // 2. Mesh, stiffness, factor, tables, C.
    Progress progress(options.telling.quiet);
    PrecomputeOptions how = options.how;
    how.memory_bytes *= 1e9;
    const Result result = compute(scene, folder, progress, how);
    if (options.folder.empty()) note_owner(folder, scene);
    // 3. What make must know to do it again.
    if (!options.depfile.empty()) {
        if (result.unchanged) touch_summary(folder);
        write_file(options.depfile, dependencies(scene, folder));
    }
    // 4. What people and scripts want to know.
    tell(options.telling, scene, folder, result);
}

}  // namespace

int main(int argc, char** argv) {
    CommandLine app(
        "Computes the tables of a soft object: a scene file with its mesh and material in, tables and C out.",
        "haptable-precompute");
    Options options;
    app.option("SCENE", options.scene, "the scene file (TOML)").required();
    const Option folder = app.option("-o", options.folder, "where to write; default BUILD/<name of the scene>");
    app.option("--build", options.build, "where folders of scenes are, each by its scene's name").excludes(folder);
    app.option("--depfile", options.depfile, "also write what the tables depend on, as a rule for make");
    app.option("--tolerance", options.how.tolerance,
               "relative error allowed in a stiffness block; 0 (default): double precision; more, 1e-4 say: single "
               "precision, in half the time, where a comparison with solves bounds the error below")
        .range(0.0, 1e-2);
    app.option("--column-tolerance", options.how.column_tolerance,
               "relative error allowed in the solves for columns.npy, which pictures are drawn from: single "
               "precision, in half the time, where a trial stays below half of it; 0: double precision")
        .range(0.0, 1e-2)
        .show_default();
    app.flag("--force", options.how.force, "compute even where DIR holds the same tables already");
    app.option("--memory", options.how.memory_bytes, "most memory to use, in GB; default: what is free").positive();
    app.option("--threads", options.how.threads,
               "default: all processors, one for less than 10,000 nodes; the tables are the same for any number")
        .range(1, 1024);
    app.flag("--json", options.telling.json, "the summary as JSON on standard output instead of the table");
    app.flag("--quiet", options.telling.quiet, "no table, no notes, no progress bar");
    app.flag("--check", options.check,
             "only judge the mesh: print what it is and what is wrong with it, and draw it in DIR/check.html");
    app.flag("--print-name", options.print_name, "only check the scene file and print its name");
    catch_interrupts();
    return run_program(app, argc, argv, [&] { run(options); });
}
