// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-bench-runs: what runs of haptable-precompute took, from their summaries, as a table for docs.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/program.hpp"
#include "host/report/page.hpp"
#include "host/tables/npy.hpp"

namespace {

using namespace haptable;
namespace fs = std::filesystem;
using Json = nlohmann::json;

/// What one run left.
struct Run {
    std::string name;
    Json summary;
    std::vector<double> stiffness_n_per_m;  ///< all entries
};

Run read_run(const std::string& argument) {
    const std::size_t equals = argument.find('=');
    if (equals == std::string::npos) throw Error(argument + ": is no NAME=DIR; give a run's name and its folder");
    const fs::path folder = argument.substr(equals + 1);
    return {argument.substr(0, equals), Json::parse(read_file(folder / "summary.json")),
            read_npy<double>(folder / "stiffness.npy").values};
}

/// Two digits of what is below 10, else three.
Number short_of(double value) {
    return number(value, value < 10.0 ? fmt::format("{:.2g}", value) : fmt::format("{:.0f}", value));
}

std::vector<double> of_processes(const Run& run, const char* key, double alone) {
    const bool has_ranks = run.summary.contains("ranks");
    return has_ranks ? run.summary.at("ranks").at(key).get<std::vector<double>>() : std::vector<double>{alone};
}

double sum_of(const Json& by_stage) {
    double sum = 0.0;
    for (const auto& [stage, value] : by_stage.items()) sum += value.get<double>();
    return sum;
}

/// Largest difference, of the largest entry.
Cell difference(const Run& run, const Run& first) {
    if (&run == &first) return "";
    const auto &a = run.stiffness_n_per_m, &b = first.stiffness_n_per_m;
    if (a.size() != b.size()) throw Error(run.name + ": has other nodes than " + first.name);
    double most = 0.0, largest = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        most = std::max(most, std::abs(a[i] - b[i]));
        largest = std::max(largest, std::abs(b[i]));
    }
    return error_of(most / largest);
}

std::vector<Cell> row_of(const Run& run, const Run& first) {
    const Json &json = run.summary, &stage_s = json.at("cpu_s");
    if (json.at("reused")) throw Error(run.name + ": took an earlier run's tables; compute it with --force");
    const auto stage = [&](const char* name) { return short_of(stage_s.at(name).get<double>()); };
    const std::vector<double> cpu_s = of_processes(run, "cpu_s", sum_of(stage_s));
    const std::vector<double> bytes = of_processes(run, "peak_bytes", json.at("memory").at("peak_bytes"));
    Number peak{{bytes}, ""};
    std::vector<std::string> megabytes;
    for (double b : bytes) megabytes.push_back(thousands(static_cast<std::uint64_t>(std::lround(b / 1e6))));
    peak.text = fmt::format("{}", fmt::join(megabytes, ", "));
    const double fill = json.at("factor").at("fill"), flops = json.at("factor").at("flops");
    return {run.name,
            thousands(json.at("counts").at("nodes")),
            number(fill, fmt::format("{:.1e}", fill)),
            number(flops, fmt::format("{:.1e}", flops)),
            stage("factor"),
            stage("blocks"),
            json.at("drawing") == "columns" ? Cell(stage("columns")) : Cell("-"),
            short_of(sum_of(json.at("time_s"))),
            short_of(std::accumulate(cpu_s.begin(), cpu_s.end(), 0.0)),
            peak,
            difference(run, first)};
}

NumberTable table_of(const std::vector<std::string>& arguments) {
    NumberTable table{{"run", "nodes", "factor nonzeros", "operations", "factor CPU s", "blocks CPU s", "columns CPU s",
                       "all, elapsed s", "all, CPU s", "peak MB", "stiffness.npy: difference"},
                      {}};
    std::vector<Run> runs;
    for (const std::string& argument : arguments) runs.push_back(read_run(argument));
    std::map<std::string, const Run*> first;  // of a body
    for (const Run& run : runs)
        table.rows.push_back(row_of(run, *first.try_emplace(run.summary.at("body_hash"), &run).first->second));
    return table;
}

}  // namespace

int main(int argc, char** argv) {
    CommandLine app("What runs of haptable-precompute took, as a table for docs.", "haptable-bench-runs");
    std::vector<std::string> runs;
    std::string topic, command;
    fs::path out;
    app.option("NAME=DIR", runs, "runs: a name for the table, and the folder that the run wrote").required();
    app.option("--topic", topic, "of the table in docs/numbers.json").required();
    app.option("--command", command, "that makes it again").required();
    app.option("-o", out, "write the numbers to this JSON file");
    return run_program(app, argc, argv, [&] {
        Numbers numbers(command);
        numbers.add(topic, table_of(runs));
        print_topics(numbers);
        if (!out.empty()) numbers.write(out);
    });
}
