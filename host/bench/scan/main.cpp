// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-bench-scan: how a surface is filled that has the noise of a scanner.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>

#include "host/base/file.hpp"
#include "host/base/program.hpp"
#include "host/mesh/read_mesh.hpp"
#include "host/mesh/surface.hpp"
#include "host/numbers/numbers.hpp"

namespace {

using namespace haptable;
namespace fs = std::filesystem;
using Eigen::Vector3d;

/// The surface of a mesh, its nodes moved along their normals by up to `share` of their shortest edge, either way.
std::string noisy_off(const TetMesh& mesh, double share) {
    const Surface surface = find_surface(mesh.tet);
    std::vector<Vector3d> normal(mesh.position_m.size(), Vector3d::Zero());
    std::vector<double> shortest(mesh.position_m.size(), HUGE_VAL);
    const auto at = [&](std::int32_t node) { return mesh.position_m[static_cast<std::size_t>(node)]; };
    for (const Patch& p : surface.patch)
        for (std::size_t c = 0; c < 3; ++c) {
            const std::int32_t a = p[c], b = p[(c + 1) % 3];
            normal[static_cast<std::size_t>(a)] += (at(p[1]) - at(p[0])).cross(at(p[2]) - at(p[0]));
            for (std::int32_t node : {a, b}) {
                double& least = shortest[static_cast<std::size_t>(node)];
                least = std::min(least, (at(b) - at(a)).norm());
            }
        }
    std::mt19937 dice(1);
    std::uniform_real_distribution<double> any(-share, share);
    std::string text = fmt::format("OFF\n{} {} 0\n", surface.node.size(), surface.patch.size());
    std::vector<std::size_t> place(mesh.position_m.size());
    for (std::size_t i = 0; i < surface.node.size(); ++i) {
        const auto node = static_cast<std::size_t>(surface.node[i]);
        place[node] = i;
        const Vector3d x = mesh.position_m[node] + any(dice) * shortest[node] * normal[node].normalized();
        text += fmt::format("{:.9g} {:.9g} {:.9g}\n", x.x(), x.y(), x.z());
    }
    for (const Patch& p : surface.patch)
        text += fmt::format("3 {} {} {}\n", place[static_cast<std::size_t>(p[0])],
                            place[static_cast<std::size_t>(p[1])], place[static_cast<std::size_t>(p[2])]);
    return text;
}

}  // namespace

int main(int argc, char** argv) {
    CommandLine app("Tells how a scan is filled: the surface of a mesh with noise along its normals.",
                    "haptable-bench-scan");
    fs::path mesh, build = "build/scan", out;
    double noise = 0.3;
    std::size_t nodes = 3000;
    app.option("MESH", mesh, "tetrahedra").required();
    app.option("--noise", noise, "of a node's shortest edge, either way").range(0.0, 1.0).show_default();
    app.option("--nodes", nodes, "to be filled with").show_default();
    app.option("--build", build, "folder for the surface").show_default();
    app.option("-o", out, "write the numbers to this JSON file");
    return run_program(app, argc, argv, [&] {
        fs::create_directories(build);
        const fs::path surface = build / "scan.off";
        write_file(surface, noisy_off(read_mesh(mesh, 1.0), noise));
        const TetMesh filled = read_mesh(surface, ReadOptions{1.0, false, {0.0, nodes}, {}});
        Numbers numbers("make bench-large PART=scan");
        NumberTable table{{fmt::format("notes, of {} nodes wanted", thousands(nodes))}, {}};
        for (const std::string& note : filled.notes) table.rows.push_back({note.substr(note.find(": ") + 2)});
        numbers.add("scan-filling", table);
        print_topics(numbers);
        if (!out.empty()) numbers.write(out);
    });
}
