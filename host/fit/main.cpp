// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-fit: a body's Young's modulus, and relaxation or stiffening, from a measured press.
//
//   record -> k, shares and times by least squares; scene's tables -> its own k; young = k / its k times the scene's
#include <fmt/format.h>

#include <algorithm>

#include "codegen/rigid_body.hpp"
#include "host/base/program.hpp"
#include "host/base/summary_lines.hpp"
#include "host/fit/fit.hpp"
#include "host/tables/modes.hpp"

namespace {

using namespace haptable;
namespace fs = std::filesystem;

struct Options {
    fs::path record, scene, tables, plot;
    std::string place = "top";
    Poke where;
    int terms = 0;
    bool stiffening = false, json = false, quiet = false;
};

void add_options(CommandLine& app, Options& o) {
    app.option("CSV", o.record, "what was measured, with the header time_s,depth_m,force_n").required();
    app.option("SCENE", o.scene, "the body that was pressed, precomputed").required();
    app.option("--tables", o.tables, "the scene's tables; without it build/NAME");
    app.option("--poke", o.place, "where it was pressed: X,Y,Z in metres, or the top").show_default();
    const auto set = [&o](const std::vector<double>& v) { o.where.direction = Eigen::Vector3d(v[0], v[1], v[2]); };
    app.numbers("--direction", set, "of the press [0,0,-1]").delimiter(',').count(3).values_name("X,Y,Z");
    app.option("--terms", o.terms, "of the relaxation; 0: as many as the record holds, up to 8")
        .range(0, 8)
        .show_default();
    app.flag("--stiffening", o.stiffening, "a slow press: find how its dent stiffens, instead of relaxation");
    app.option("--plot", o.plot, "draw record, fit and misfit into this .svg (gnuplot)");
    app.flag("--json", o.json, "print the summary as JSON");
    app.flag("--quiet", o.quiet, "print nothing but errors (and what --json asks for)");
}

SummaryLines summary_of(const Scene& scene, const ForceRecord& record, const PronyFit& fit, double own_n_per_m) {
    SummaryLines summary;
    summary.add("scene", scene.name);
    summary.add("samples", static_cast<std::int64_t>(record.time_s.size()));
    summary.add("stiffness_n_per_m", fit.stiffness_n_per_m);
    summary.add("scene_stiffness_n_per_m", own_n_per_m);
    summary.add("stiffness_factor", fit.stiffness_n_per_m / own_n_per_m);
    summary.add("stiffness_error", fit.stiffness_error);
    summary.add("misfit_n", fit.misfit_n);
    summary.add("misfit_of_largest_force",
                fit.misfit_n / *std::max_element(record.force_n.begin(), record.force_n.end()));
    summary.add("terms", static_cast<std::int64_t>(fit.relaxation.size()));
    for (std::size_t k = 0; k < fit.relaxation.size(); ++k) {
        summary.add(fmt::format("share_{}", k + 1), fit.relaxation[k].share);
        summary.add(fmt::format("time_{}_s", k + 1), fit.relaxation[k].time_s);
    }
    return summary;
}

/// What a slow press gives.
void print_dent(const Options& o, const Scene& scene, const ForceRecord& record, double own_n_per_m) {
    if (scene.material.orthotropic || !scene.regions.empty())
        throw Error(o.scene.string() + ": stiffening is of one isotropic material: remove the regions, or its law");
    const DentFit fit = fit_dent(record);
    SummaryLines summary;
    summary.add("scene", scene.name);
    summary.add("samples", static_cast<std::int64_t>(record.time_s.size()));
    summary.add("stiffness_n_per_m", fit.stiffness_n_per_m);
    summary.add("scene_stiffness_n_per_m", own_n_per_m);
    for (std::size_t k = 0; k < fit.curve.c.size(); ++k) summary.add(fmt::format("c_{}", k + 1), fit.curve.c[k]);
    summary.add("energy_j", fit.curve.energy_j);
    summary.add("misfit_n", fit.misfit_n);
    summary.print(o.json, o.quiet);
    if (!o.json && !o.quiet) fmt::print("\n{}", scene_lines(scene, fit.stiffness_n_per_m / own_n_per_m, fit));
}

void run(Options& o) {
    const ForceRecord record = read_force_record(o.record);
    const Scene scene = read_scene(o.scene);
    if (o.tables.empty()) o.tables = fs::path("build") / scene.name;
    if (!fs::exists(o.tables / "tables.json"))
        throw Error(o.tables.string() + ": holds no tables of the scene: run haptable-precompute, or give --tables");
    const TablesFolder folder(o.tables);
    refuse_free_body(folder, "haptable-fit");
    o.where.depth_m = *std::max_element(record.depth_m.begin(), record.depth_m.end());
    const double own_n_per_m = stiffness_at_once(read_tables(folder), read_modes(folder), o.place, o.where);
    if (o.stiffening) return print_dent(o, scene, record, own_n_per_m);
    const PronyFit fit = fit_prony(record, static_cast<std::size_t>(o.terms), 8);
    if (!o.quiet && fit.relaxation.size() < static_cast<std::size_t>(o.terms))
        fmt::print(stderr, "haptable-fit: note: the record determines {} terms, not {}\n", fit.relaxation.size(),
                   o.terms);
    if (!o.plot.empty()) plot_fit(record, fit, o.plot);
    summary_of(scene, record, fit, own_n_per_m).print(o.json, o.quiet);
    if (!o.json && !o.quiet) fmt::print("\n{}", scene_lines(scene, fit.stiffness_n_per_m / own_n_per_m, fit));
}

}  // namespace

int main(int argc, char** argv) {
    CommandLine app("Finds a body's Young's modulus, and relaxation or stiffening, from a measured press.",
                    "haptable-fit");
    Options options;
    add_options(app, options);
    return run_program(app, argc, argv, [&] { run(options); });
}
