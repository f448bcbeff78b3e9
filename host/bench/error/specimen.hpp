// SPDX-License-Identifier: GPL-2.0-or-later
// The bodies that speed and error are measured on: their meshes, the places that are pressed, and how stiff the body
// itself is there.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/mesh/mesh.hpp"
#include "host/numbers/numbers.hpp"
#include "host/scene/scene.hpp"

namespace haptable {

struct Place {
    Eigen::Vector3d on_m;     ///< on the surface at rest
    Eigen::Vector3d outward;  ///< unit normal
};

/// What stands for the body: quadratic elements on a mesh that no configuration has, and on a coarser one.
struct Truth {
    Place place;
    Eigen::Matrix3d stiffness_n_per_m;  ///< S: the finger feels -S u
    double coarser = 0.0;               ///< relative change of n . S n on the coarser mesh
};

enum class Fineness { kCoarse, kMiddle, kFine };

/// One mesh of a body.
struct Meshed {
    std::string name;  ///< "13 a side", "1,713 nodes"
    Scene scene;       ///< without columns
    Fineness fineness = Fineness::kCoarse;
};

struct Specimen {
    std::string name;
    double finger_radius_m;  ///< of the footprint, and of the mask
    std::vector<Meshed> meshes;
};

/// The cubes (nu 0.3 and 0.49), the mouse and the liver; `quick`: with fewer meshes. Finer meshes of files are written
/// below `build`.
std::vector<Specimen> specimens(bool quick, const std::filesystem::path& build);

/// The places that are pressed, twelve.
std::vector<Place> places_of(const Specimen& specimen);

/// A spiral of `count` places on a plane that faces +z, `width_m` across: no mesh has its nodes there.
std::vector<Place> spiral(const Eigen::Vector3d& middle_m, double width_m, std::size_t count);

/// Twelve points of a mesh's patches around which its surface is free and nearly flat as far as the finger reaches.
std::vector<Place> mesh_places(const Scene& scene, const TetMesh& mesh, double radius_m);

/// Solves for the body itself. Minutes; on the coarser mesh alone, which then stands for both, a part of one.
std::vector<Truth> solve_truth(const Specimen& specimen, bool coarser_alone = false);

/// The truth as a table for numbers.json, and read back from there. Throws Error where a specimen has none.
NumberTable truth_table(const std::vector<std::pair<std::string, std::vector<Truth>>>& truths);
std::vector<Truth> truth_of(const nlohmann::ordered_json& topics, const std::string& specimen);

}  // namespace haptable
