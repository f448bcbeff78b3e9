// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-keys: the table of a scene's keys into the page and the schema that show it (make scene-keys).
#include <filesystem>

#include "host/base/file.hpp"
#include "host/base/program.hpp"
#include "host/scene/manual.hpp"

int main(int argc, char** argv) {
    haptable::CommandLine app("Writes the keys of a scene into their page and the JSON Schema for editors.",
                              "haptable-keys");
    std::filesystem::path page, schema;
    app.option("PAGE", page, "docs/SCENE.md, whose tables are made anew").required();
    app.option("SCHEMA", schema, "docs/scene.schema.json").required();
    return haptable::run_program(app, argc, argv, [&] {
        haptable::write_file(page, haptable::with_keys(haptable::read_file(page)));
        haptable::write_file(schema, haptable::scene_schema());
    });
}
