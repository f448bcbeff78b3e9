// SPDX-License-Identifier: GPL-2.0-or-later
// The part of haptable-gmsh.so: what Gmsh's library reads, packed. It runs in a child process
// (host/mesh/read_gmsh.cpp).
#include <fmt/format.h>
#include <gmsh.h>

#include <algorithm>

#include "host/base/error.hpp"
#include "host/mesh/modules.hpp"
#include "host/mesh/pack.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& file, const std::string& what) { throw Error(file.string() + ": " + what); }

std::vector<std::string> log_lines(std::string_view level) {
    std::vector<std::string> all, lines;
    gmsh::logger::get(all);
    for (const std::string& line : all)
        if (line.starts_with(level)) lines.push_back(line.substr(level.size()));
    return lines;
}

void open_in_gmsh(const fs::path& file, const std::string& staged) {
    gmsh::initialize(0, nullptr, false);
    gmsh::option::setNumber("General.Terminal", 0);
    gmsh::logger::start();
    bool thrown = false;
    try {
        gmsh::open(staged);
    } catch (...) {  // the library throws texts, numbers and exceptions; its log has the reason
        thrown = true;
    }
    constexpr std::string_view kTwice = "Skipping duplicate node ";
    for (const std::string& warning : log_lines("Warning: "))
        if (warning.starts_with(kTwice))
            fail(file, fmt::format("node number {} is given twice; give every node a number of its own",
                                   warning.substr(kTwice.size())));
    const std::vector<std::string> errors = log_lines("Error: ");
    if (thrown || !errors.empty())
        fail(file, fmt::format("Gmsh cannot read it: {}; save the mesh again",
                               errors.empty() || errors.front().find(staged) != std::string::npos ? "it is damaged"
                                                                                                  : errors.front()));
}

/// How many nodes each element of a type has, and its name and dimension.
struct ElementType {
    std::string name;
    int dimension = 0, nodes = 0;
};

ElementType element_type(int type) {
    ElementType result;
    int order = 0, primary = 0;
    std::vector<double> local;
    gmsh::model::mesh::getElementProperties(type, result.name, result.dimension, order, result.nodes, local, primary);
    return result;
}

void pack_elements(Packer& out, int dimension, int entity) {
    std::vector<int> types;
    std::vector<std::vector<std::size_t>> tags, nodes;
    gmsh::model::mesh::getElements(types, tags, nodes, dimension, entity);
    out.one(types.size());
    for (std::size_t k = 0; k < types.size(); ++k) {
        const ElementType type = element_type(types[k]);
        out.one(types[k]);
        out.text(type.name);
        out.one(type.dimension);
        out.one(type.nodes);
        out.list(tags[k]);
        out.list(nodes[k]);
    }
}

std::string pack_model() {
    Packer out;
    std::vector<std::size_t> tags;
    std::vector<double> coordinate, parameter;
    gmsh::model::mesh::getNodes(tags, coordinate, parameter);
    out.list(tags);
    out.list(coordinate);
    const std::vector<std::string> warnings = log_lines("Warning: ");
    out.one(warnings.size());
    for (const std::string& warning : warnings) out.text(warning);
    pack_elements(out, -1, -1);
    gmsh::vectorpair groups;
    gmsh::model::getPhysicalGroups(groups);
    out.one(groups.size());
    for (const auto& [dimension, tag] : groups) {
        std::string name;
        gmsh::model::getPhysicalName(dimension, tag, name);
        constexpr const char* kNames[] = {"point", "curve", "surface", "volume"};
        out.text(name.empty() ? fmt::format("{} {}", kNames[std::clamp(dimension, 0, 3)], tag) : name);
        std::vector<int> entities;
        gmsh::model::getEntitiesForPhysicalGroup(dimension, tag, entities);
        out.one(entities.size());
        for (int entity : entities) pack_elements(out, dimension, entity);
    }
    return out.take();
}

}  // namespace

}  // namespace haptable

void haptable_gmsh_read(const std::filesystem::path& file, const std::string& staged, std::string& packed) {
    haptable::open_in_gmsh(file, staged);
    packed = haptable::pack_model();
}
