// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/error/calculix.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <sstream>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/shell.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

/// Millimetres, newtons and megapascals: CalculiX prints seven digits, and its tolerances suit such numbers. It reads
/// 20 characters of a number: 13 digits.
constexpr double kMillimetres = 1e3, kMegapascals = 1e-6;

std::string list_of(std::span<const std::int32_t> nodes) {
    std::string text;
    for (std::int32_t node : nodes) text += fmt::format("{},\n", node + 1);
    return text;
}

std::string material_of(const Deck& deck) {
    const double e = kMegapascals * deck.material.young_pa, nu = deck.material.poisson;
    if (!deck.large_strain) return fmt::format("*ELASTIC\n{:.13g},{:.13g}\n", e, nu);
    const double mu = e / (2.0 * (1.0 + nu)), kappa = e / (3.0 * (1.0 - 2.0 * nu));
    return fmt::format("*HYPERELASTIC, NEO HOOKE\n{:.13g},{:.13g}\n", 0.5 * mu, 2.0 / kappa);
}

/// In tonnes a cubic millimetre.
std::string density_of(const Deck& deck) {
    return deck.density_kg_per_m3 > 0.0 ? fmt::format("*DENSITY\n{:.13g}\n", 1e-12 * deck.density_kg_per_m3) : "";
}

std::string step_of(const Deck& deck, const NodalForces& load) {
    std::string text = fmt::format("*STEP{}\n*STATIC\n*CLOAD, OP=NEW\n", deck.large_strain ? ", NLGEOM, INC=200" : "");
    for (const auto& [node, force] : load)
        for (int c = 0; c < 3; ++c) text += fmt::format("{},{},{:.13g}\n", node + 1, c + 1, force[c]);
    return text + deck.loads + "*NODE PRINT, NSET=NALL, FREQUENCY=1000\nU\n*END STEP\n";  // the last increment alone
}

/// Nodes, elements, material and what is held.
std::string model_of(const Deck& deck) {
    std::string text = "*NODE, NSET=NALL\n";
    for (std::size_t i = 0; i < deck.position_m.size(); ++i) {
        const Eigen::Vector3d x = kMillimetres * deck.position_m[i];
        text += fmt::format("{},{:.13g},{:.13g},{:.13g}\n", i + 1, x[0], x[1], x[2]);
    }
    text += fmt::format("*ELEMENT, TYPE=C3D{}, ELSET=EALL\n", deck.element.front().size());
    for (std::size_t e = 0; e < deck.element.size(); ++e) {
        text += fmt::format("{}", e + 1);
        for (std::int32_t node : deck.element[e]) text += fmt::format(",{}", node + 1);
        text += "\n";
    }
    return text + "*NSET, NSET=HELD\n" + list_of(deck.held) +
           (deck.sections.empty() ? "*MATERIAL, NAME=BODY\n" + material_of(deck) + density_of(deck) +
                                        "*SOLID SECTION, ELSET=EALL, MATERIAL=BODY\n"
                                  : deck.sections) +
           (deck.held.empty() ? "" : "*BOUNDARY\nHELD,1,3\n");
}

std::string text_of(const Deck& deck, std::span<const NodalForces> loads) {
    std::string text = model_of(deck);
    for (const NodalForces& load : loads) text += step_of(deck, load);
    return text;
}

/// The tables of job.dat: a title, an empty line, then "node ux uy uz" lines.
std::vector<Displacements> read_results(const fs::path& file, std::size_t nodes) {
    std::vector<Displacements> results;
    std::istringstream lines(read_file(file));
    for (std::string line; std::getline(lines, line);) {
        if (line.find("displacements") != std::string::npos) results.emplace_back(nodes, Eigen::Vector3d::Zero());
        std::istringstream cells(line);
        std::size_t node = 0;
        Eigen::Vector3d u;
        if (results.empty() || !(cells >> node >> u[0] >> u[1] >> u[2]) || node < 1 || node > nodes) continue;
        results.back()[node - 1] = u / kMillimetres;
    }
    return results;
}

/// The lines "mode omega^2 omega frequency 0" below the first title.
std::vector<double> read_frequencies(const fs::path& file) {
    std::vector<double> frequency_hz;
    std::istringstream lines(read_file(file));
    for (std::string line; std::getline(lines, line) && line.find("P A R T I C I P A T I O N") == std::string::npos;) {
        std::istringstream cells(line);
        std::size_t mode = 0;
        double squared = 0.0, omega = 0.0, hz = 0.0;
        if (cells >> mode >> squared >> omega >> hz) frequency_hz.push_back(hz);
    }
    return frequency_hz;
}

/// Runs `ccx` on that text; its folder then has job.dat, or not.
int run_ccx(const std::string& text, const fs::path& folder) {
    fs::create_directories(folder);
    write_file(folder / "job.inp", text);
    fs::remove(folder / "job.dat");
    const std::string command = fmt::format("cd {} && ccx -i job >job.log 2>&1", shell_quoted(folder));
    return std::system(command.c_str());  // NOLINT: the folder is the bench's own
}

}  // namespace

std::vector<std::int32_t> held_of(std::span<const std::int32_t> unknown) {
    std::vector<std::int32_t> held;
    for (std::size_t i = 0; i < unknown.size(); ++i)
        if (unknown[i] < 0) held.push_back(static_cast<std::int32_t>(i));
    return held;
}

std::vector<Displacements> run_calculix(const Deck& deck, std::span<const NodalForces> loads, const fs::path& folder) {
    const int status = run_ccx(text_of(deck, loads), folder);
    auto results = fs::exists(folder / "job.dat") ? read_results(folder / "job.dat", deck.position_m.size())
                                                  : std::vector<Displacements>();
    if (results.size() != loads.size() && !(deck.large_strain && !results.empty()))
        throw Error(fmt::format(
            "ccx ended with {} and {} of {} results; see {} (calculix-ccx is in: sh scripts/setup.sh bench)", status,
            results.size(), loads.size(), (folder / "job.log").string()));
    return results;
}

std::vector<double> calculix_frequencies(const Deck& deck, int count, const fs::path& folder) {
    const std::string step = fmt::format("*STEP\n*FREQUENCY\n{}\n*END STEP\n", count);
    const int status = run_ccx(model_of(deck) + step, folder);
    auto frequency_hz = fs::exists(folder / "job.dat") ? read_frequencies(folder / "job.dat") : std::vector<double>();
    if (frequency_hz.size() < static_cast<std::size_t>(count))
        throw Error(fmt::format("ccx ended with {} and {} of {} frequencies; see {}", status, frequency_hz.size(),
                                count, (folder / "job.log").string()));
    return frequency_hz;
}

}  // namespace haptable
