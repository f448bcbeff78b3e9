// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/run/places.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <vector>

#include "host/base/child.hpp"
#include "host/base/command_line.hpp"
#include "host/base/error.hpp"
#include "host/base/installed.hpp"
#include "host/base/interrupt.hpp"

namespace haptable {

namespace fs = std::filesystem;

namespace {

constexpr std::array kTargets{"cortex-m4", "cortex-m7", "cortex-m33", "rv32"};

bool is_newer(const fs::path& file, const fs::path& than) {
    std::error_code missing;
    const auto time = fs::last_write_time(file, missing), other = fs::last_write_time(than, missing);
    return !missing && time >= other;
}

bool is_project_here() { return fs::exists("Makefile") && fs::exists("scripts/qemu.sh"); }

/// The words for a user: what `scene` makes more than `scene-alone` are the other programs.
std::string words_of(const std::vector<std::string>& words) {
    return words.front() == "scene-alone" ? "scene " + words.back() : fmt::format("{}", fmt::join(words, " "));
}

/// Runs it in sight, unless `quiet`.
void run_maker(const std::string& name, const std::vector<std::string>& command, bool quiet) {
    Child child(name, command);
    std::size_t told = 0;
    while (!child.has_ended()) {
        stop_if_interrupted();
        child.wait_some(std::chrono::milliseconds(200));
        if (!quiet) std::fputs(child.out().substr(std::min(told, child.out().size())).c_str(), stderr);
        told = child.out().size();
    }
    if (!child.is_well()) throw Error(child.how_it_ended());
}

/// In haptable's own folder, `make` knows best whether anything is to be done.
void make(const std::vector<std::string>& words, bool quiet) {
    std::vector<std::string> command{"make", "--no-print-directory"};
    command.insert(command.end(), words.begin(), words.end());
    run_maker("make", command, quiet);
}

void build_installed(const fs::path& scene_file, const fs::path& folder, bool quiet) {
    std::vector<std::string> command{(program_folder() / "haptable-build").string(), scene_file.string(), "-o",
                                     folder.string()};
    if (quiet) command.emplace_back("--quiet");
    run_maker("haptable-build", command, quiet);
}

void require(const fs::path& file, const fs::path& scene_file, const fs::path& build,
             const std::vector<std::string>& words, bool quiet) {
    if (is_newer(file, scene_file)) return;
    if (!is_project_here()) {
        if (fs::exists(file)) return;  // copied, or installed: of what time is no matter
        throw Error(fmt::format("{} is missing: in haptable's folder run: make {}", file.string(), words_of(words)));
    }
    std::vector<std::string> all = words;
    all.push_back("BUILD=" + build.string());
    make(all, quiet);
    if (!fs::exists(file)) throw Error(file.string() + ": make did not make it");
}

}  // namespace

Places find_places(const fs::path& scene_file, const std::string& name, const std::string& target, bool quiet) {
    Places places;
    places.programs = program_folder();
    const bool installed = is_installed();
    places.build = scenes_folder();
    places.scene = places.build / name;
    if (installed && !target.empty())
        throw Error("--target: runs in haptable's source folder, not where it is installed");
    if (installed) {
        if (!is_newer(places.scene / "servo", scene_file)) build_installed(scene_file, places.scene, quiet);
        return places;
    }
    const std::string scene = "SCENE=" + scene_file.string();
    require(places.scene / "servo", scene_file, places.build, {"scene-alone", scene}, quiet);
    if (target.empty()) return places;
    if (std::find(kTargets.begin(), kTargets.end(), target) == kTargets.end())
        throw BadCommandLine(fmt::format("--target: \"{}\" is none of {}", target, fmt::join(kTargets, ", ")));
    places.image = places.scene / "firmware" / target / "loop.elf";
    require(places.image, scene_file, places.build, {"firmware", scene, "TARGET=" + target}, quiet);
    if (!is_project_here())
        throw Error("--target: QEMU is started by haptable's scripts: run this in haptable's folder");
    return places;
}

}  // namespace haptable
