// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-codegen: the tables of a precompute folder as C, again; or as a folder for another project.
#include <filesystem>

#include "codegen/codegen.hpp"
#include "codegen/export.hpp"
#include "host/base/own_folder.hpp"
#include "host/base/program.hpp"
#include "host/tables/own_tables.hpp"

int main(int argc, char** argv) {
    haptable::CommandLine app(
        "Writes model.h and model.c from the tables of a haptable-precompute folder, into that folder.",
        "haptable-codegen");
    std::filesystem::path folder, out;
    std::string kind;
    app.option("DIR", folder, "folder that haptable-precompute wrote").required();
    const haptable::Option exported = app.option(
        "--export", kind,
        "then write servo and tables as a library for: arduino, cmake, cmsis-pack, esp-idf, platformio, zephyr");
    const haptable::Option to = app.option("-o", out, "folder of that library, which is new");
    exported.needs(to);
    to.needs(exported);
    return haptable::run_program(app, argc, argv, [&] {
        {
            haptable::OwnFolder own(folder, haptable::kTables, haptable::own_tables_in(folder));
            for (const char* file : {"model.h", "model.c", "display.h", "display.c"}) own.file(file);
            haptable::generate_model(folder);
        }
        if (!kind.empty()) haptable::export_servo(folder, kind, out);
    });
}
