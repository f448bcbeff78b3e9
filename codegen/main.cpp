// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-codegen: the tables of a precompute folder as C, again.
#include <filesystem>

#include "codegen/codegen.hpp"
#include "host/base/program.hpp"

int main(int argc, char** argv) {
    haptable::CommandLine app(
        "Writes model.h and model.c from the tables of a haptable-precompute folder, into that folder.",
        "haptable-codegen");
    std::filesystem::path folder;
    app.option("DIR", folder, "folder that haptable-precompute wrote").required();
    return haptable::run_program(app, argc, argv, [&] { haptable::generate_model(folder); });
}
