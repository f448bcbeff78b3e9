// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/export.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "codegen/codegen.hpp"
#include "codegen/loaded_scene.hpp"
#include "codegen/template.hpp"
#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/installed.hpp"
#include "host/base/program.hpp"
#include "host/base/text.hpp"

namespace haptable {

namespace fs = std::filesystem;

namespace {

/// A folder that comes with the programs.
fs::path require_part(const std::string& name) {
    fs::path part = find_part(name);
    if (part.empty())
        throw Error(fmt::format("{} is not in {}: run make, or install haptable again", name,
                                (program_folder().parent_path() / "lib").string()));
    return part;
}

std::vector<fs::path> files_of(const fs::path& folder, const std::string& extension) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder))
        if (entry.path().extension() == extension) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

/// The scene's name as part of an identifier: of CMake, Kconfig, C.
std::string plain(std::string name) {
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
}

/// The names of files, each in a line of that form.
std::string lines(const std::vector<fs::path>& files, fmt::format_string<std::string> form) {
    std::vector<std::string> text;
    for (const fs::path& file : files) text.push_back(fmt::format(form, file.filename().string()));
    return fmt::format("{}", fmt::join(text, "\n"));
}

TemplateValues values_of(const TablesFolder& folder, const ServoSources& files) {
    const LoadedScene scene(folder);
    const Tables& tables = scene.tables();
    return {{"name", "haptable_" + plain(tables.name)},
            {"NAME", "HAPTABLE_" + upper(plain(tables.name))},
            {"scene", tables.name},
            {"version", kVersion},
            {"tables_hash", fmt::format("{:016x}", scene.model().hash)},
            {"flash_bytes", std::to_string(flash_bytes(scene.servo()))},
            {"sources", lines(files.sources, "    src/{}")},
            {"component_files", lines(files.sources, "        <file category=\"sourceC\" name=\"src/{}\"/>")}};
}

void copy_into(const fs::path& folder, const std::vector<fs::path>& files) {
    for (const fs::path& file : files) write_file(folder / file.filename(), read_file(file));
}

}  // namespace

ServoSources servo_sources(const fs::path& firmware, const fs::path& tables) {
    ServoSources files{files_of(firmware, ".c"), files_of(firmware, ".h")};
    files.sources.push_back(tables / "model.c");
    files.headers.push_back(tables / "model.h");
    if (fs::exists(tables / "display.c")) {
        files.sources.push_back(tables / "display.c");
        files.headers.push_back(tables / "display.h");
    }
    const auto by_name = [](const fs::path& a, const fs::path& b) { return a.filename() < b.filename(); };
    std::sort(files.sources.begin(), files.sources.end(), by_name);
    std::sort(files.headers.begin(), files.headers.end(), by_name);
    return files;
}

std::vector<std::string> export_kinds() {
    std::vector<std::string> kinds;
    for (const auto& entry : fs::directory_iterator(require_part("boards")))
        if (entry.is_directory() && entry.path().filename() != "examples")
            kinds.push_back(entry.path().filename().string());
    std::sort(kinds.begin(), kinds.end());
    return kinds;
}

void export_servo(const fs::path& tables, const std::string& kind, const fs::path& out) {
    const std::vector<std::string> kinds = export_kinds();
    if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end())
        throw Error(fmt::format("--export: \"{}\" is none of {}", kind, fmt::join(kinds, ", ")));
    if (fs::exists(out) && !fs::is_empty(out))
        throw Error(out.string() + ": is there already: remove it, or name another folder");
    const ServoSources files = servo_sources(require_part("firmware"), tables);
    const TemplateValues values = values_of(tables, files);
    const fs::path templates = require_part("boards") / kind;
    StagedPath beside(out, StagedKind::folder);
    fs::create_directories(beside.path() / "src");
    copy_into(beside.path() / "src", files.sources);
    copy_into(beside.path() / "src", files.headers);
    for (const auto& entry : fs::recursive_directory_iterator(templates)) {
        if (entry.is_directory()) continue;
        const fs::path to = beside.path() / filled(entry.path().lexically_relative(templates).string(), values);
        fs::create_directories(to.parent_path());
        write_file(to, filled(read_file(entry.path()), values));
    }
    for (const fs::path& example : files_of(require_part("boards") / "examples", ".c")) {
        if (fs::exists(templates / "examples")) break;  // it has its own
        fs::create_directories(beside.path() / "examples");
        write_file(beside.path() / "examples" / example.filename(), filled(read_file(example), values));
    }
    write_file(beside.path() / "README.md", filled(read_file(require_part("boards") / "README.md"), values));
    beside.commit();
}

}  // namespace haptable
