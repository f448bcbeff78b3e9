// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/fit/fit.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "codegen/body_modes.hpp"
#include "codegen/in_memory.hpp"
#include "host/base/child.hpp"
#include "host/base/colors.hpp"
#include "host/base/error.hpp"
#include "host/base/file.hpp"

namespace haptable {

namespace {

constexpr std::chrono::seconds kPatience{60};

std::string data_of(const char* name, const std::vector<double>& time_s, const std::vector<double>& value) {
    std::string text = fmt::format("${} << END\n", name);
    for (std::size_t i = 0; i < value.size(); ++i)
        fmt::format_to(std::back_inserter(text), "{:.9g} {:.9g}\n", time_s[i], value[i]);
    return text + "END\n";
}

std::string plot_script() {
    return fmt::format(
        "set terminal svg size 900,480 font 'DejaVu Sans,11' background 'white'\nset output 'fit.svg'\n"
        "set multiplot layout 2,1\nset grid lc rgb '{}'\nset lmargin 10\nset rmargin 3\nset ylabel 'N'\n"
        "plot $measured with points pt 7 ps 0.3 lc rgb '{}' title 'measured', $fitted with lines lw 1.5 lc rgb '{}' "
        "title 'fit'\nset xlabel 's'\nset ylabel 'fit - measured, N'\n"
        "plot $misfit with lines lc rgb '{}' notitle\nunset multiplot\n",
        css(drawn_color("grid_line")), css(drawn_color("measured")), css(drawn_color("first_curve")),
        css(drawn_color("second_curve")));
}

}  // namespace

double stiffness_at_once(Tables tables, const std::optional<ModeTables>& body_modes, const std::string& place,
                         Poke where) {
    tables.relaxation.clear();
    tables.stiffening = {};
    tables.limits = {};
    tables.static_friction = tables.kinetic_friction = 0.0;
    tables.max_force_n = 1e9;
    const ServoModel servo = build_model(tables);
    const haptable_model model = model_in_memory(tables, servo);
    const std::vector<std::uint32_t> node(servo.node.begin(), servo.node.end());
    where.at_m = place_of(place, model);
    ServoModes ringing;
    haptable_modes modes{};
    if (body_modes) {
        ringing = build_modes(*body_modes, tables, servo);
        modes = modes_in_memory(ringing);
    }
    const Poked end = poke({&model, node.data(), tables.name.c_str(), nullptr, body_modes ? &modes : nullptr}, where);
    return end.force_n.norm() / end.depth_m;
}

std::string scene_lines(const Scene& scene, double factor, const DentFit& fit) {
    return fmt::format(
        "[material]\nyoung = {:.6g}  # Pa, of a small dent\npoisson = {:g}\n"
        "stiffening = {{ curve = [{:.6g}], energy = {:.6g} }}\n",
        factor * scene.material.young_pa, scene.material.poisson, fmt::join(fit.curve.c, ", "), fit.curve.energy_j);
}

std::string scene_lines(const Scene& scene, double factor, const PronyFit& fit) {
    const bool is_one =
        !scene.material.orthotropic && scene.regions.empty() && scene.membranes.empty() && scene.beds.empty();
    std::string text =
        is_one ? fmt::format("[material]\nyoung = {:.6g}  # Pa, at once; +- {:.2g} %\npoisson = {:g}\n",
                             factor * scene.material.young_pa, 100.0 * fit.stiffness_error, scene.material.poisson)
               : fmt::format("# all moduli of the scene, of its membranes and beds too, times {:.6g}; +- {:.2g} %\n",
                             factor, 100.0 * fit.stiffness_error);
    for (std::size_t k = 0; k < fit.relaxation.size(); ++k)
        text += fmt::format("\n[[relaxation]]\nshare = {:.6g}  # +- {:.2g} %\ntime = {:.6g}  # s, +- {:.2g} %\n",
                            fit.relaxation[k].share, 100.0 * fit.share_error[k], fit.relaxation[k].time_s,
                            100.0 * fit.time_error[k]);
    return text;
}

void plot_fit(const ForceRecord& record, const PronyFit& fit, const std::filesystem::path& svg) {
    std::vector<double> misfit_n(fit.force_n);
    for (std::size_t i = 0; i < misfit_n.size(); ++i) misfit_n[i] -= record.force_n[i];
    const StagedPath scratch(svg.string() + ".plot", StagedKind::folder);
    write_file(scratch.path() / "fit.gnuplot", data_of("measured", record.time_s, record.force_n) +
                                                   data_of("fitted", record.time_s, fit.force_n) +
                                                   data_of("misfit", record.time_s, misfit_n) + plot_script());
    Child gnuplot("gnuplot", {"gnuplot", "fit.gnuplot"}, scratch.path().string());
    gnuplot.wait(kPatience);
    if (!gnuplot.is_well())
        throw Error(fmt::format("{}: gnuplot (Debian: gnuplot-nox) does not draw it: {}", svg.string(),
                                gnuplot.how_it_ended()));
    write_file(svg, read_file(scratch.path() / "fit.svg"));
}

}  // namespace haptable
