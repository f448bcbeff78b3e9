// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-report: measured numbers from the programs that measure into docs/numbers.json, and from there into the
// pages.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/program.hpp"
#include "host/report/numbers.hpp"
#include "host/report/page.hpp"

namespace {

using namespace haptable;
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

void take_folder(const fs::path& folder, Json& topics) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder))
        if (entry.path().extension() == ".json") files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files) take(read_numbers(file), topics);
}

void fill_pages(const std::vector<Page>& pages, const Json& topics) {
    for (const Page& page : pages) {
        const std::string filled = fill(page, topics);
        if (filled != page.text) write_file(page.path, filled);
    }
}

void check(const std::vector<Page>& pages, const Json& topics) {
    const std::vector<std::string> faults = find_faults(pages, topics);
    for (const std::string& fault : faults) fmt::print(stderr, "{}\n", fault);
    if (!faults.empty()) throw Error(fmt::format("{} faults in the numbers of the pages; mend them", faults.size()));
}

}  // namespace

int main(int argc, char** argv) {
    CommandLine app("Puts measured numbers into the pages of docs.", "haptable-report");
    fs::path numbers = "docs/numbers.json", folder;
    std::vector<fs::path> paths;
    std::string plot;
    bool only_check = false, list_runs = false;
    app.option("PAGE", paths, "Markdown pages with markers <!-- topic --> <!-- /topic -->");
    app.option("--numbers", numbers, "the numbers that pages quote").show_default();
    app.option("--take", folder, "first take the numbers of every .json in this folder into them");
    app.option("--plot", plot, "print the values of this topic, a table, for gnuplot");
    app.flag("--runs", list_runs, "print which commands measured what, on which machine, as a table in Markdown");
    app.flag("--check", only_check, "write nothing: every marker has its number, every number one page");
    return run_program(app, argc, argv, [&] {
        Json topics = fs::exists(numbers) || folder.empty() ? read_numbers(numbers) : Json::object();
        if (!folder.empty()) {
            take_folder(folder, topics);
            write_file(numbers, to_text(topics));
        }
        if (!plot.empty() && !topics.contains(plot)) throw Error(fmt::format("{}: has no {}", numbers.string(), plot));
        if (!plot.empty()) fmt::print("{}", to_plot_data(topics.at(plot)));
        if (list_runs) fmt::print("{}", runs(topics));
        std::vector<Page> pages;
        for (const fs::path& path : paths) pages.push_back({path, read_file(path)});
        only_check ? check(pages, topics) : fill_pages(pages, topics);
    });
}
