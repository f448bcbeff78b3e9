// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-contact: what the contact modes feel like and cost: numbers for docs/CONTACT.md, and curves
// for their plots.
#include <filesystem>

#include "host/base/file.hpp"
#include "host/base/program.hpp"
#include "host/bench/contact/beside.hpp"
#include "host/bench/contact/cost.hpp"
#include "host/bench/contact/curves.hpp"
#include "host/bench/contact/feel.hpp"
#include "host/numbers/numbers.hpp"

int main(int argc, char** argv) {
    using namespace haptable;
    CommandLine app("Measures what the contact modes feel like and cost.", "haptable-contact");
    std::filesystem::path build = "build/contact", out;
    int repetitions = 15, loops = 1000;
    bool only_curves = false, only_beside = false;
    app.option("--build", build, "folder for tables and curves").show_default();
    app.option("-o", out, "write the numbers to this JSON file");
    app.option("--repetitions", repetitions, "of each timing; the median counts");
    app.option("--loops", loops, "random closed loops a body and mode");
    app.flag("--curves", only_curves, "only the curves: line.dat, loop.dat and edge.dat in the folder");
    app.flag("--beside", only_beside, "only the times beside a finger proxy");
    return run_program(app, argc, argv, [&] {
        std::filesystem::create_directories(build);
        Numbers numbers("make bench");
        const auto beside = [&] {
            const auto [finger, shell] = beside_proxies(build, 2 * repetitions);
            numbers.add("modes-beside", finger);
            numbers.add("modes-beside-shells", shell);
        };
        if (only_beside) {
            beside();
            print_topics(numbers);
            if (!out.empty()) numbers.write(out);
            return;
        }
        const StiffnessLine line = stiffness_along_a_line(build);
        write_file(build / "line.dat", line.text());
        write_file(build / "loop.dat", energy_around_a_loop(build));
        write_file(build / "edge.dat", force_over_an_edge(build));
        if (only_curves) return;
        numbers.add("modes-cost", cost_of_modes(build, repetitions));
        beside();
        numbers.add("feel-stiffness", stiffness_table(line));
        numbers.add("feel-loops", loop_table(build, loops));
        numbers.add("feel-change", change_table(build));
        numbers.add("feel-settling", settling(build));
        numbers.add("feel-jumps", jump_table(build));
        numbers.add("feel-release", release_table(build));
        print_topics(numbers);
        if (!out.empty()) numbers.write(out);
    });
}
