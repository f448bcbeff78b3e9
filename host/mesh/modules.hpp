// SPDX-License-Identifier: GPL-2.0-or-later
// What the shared objects in lib/ export. Gmsh and CGAL stand behind them: Gmsh's library brings a hundred others,
// which take a tenth of a second to load, and a body that is made or is VTK XML needs neither.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <string_view>

#include "host/mesh/fill.hpp"
#include "host/mesh/in_child.hpp"
#include "host/mesh/readers.hpp"
#include "host/mesh/soup.hpp"

extern "C" {

/// lib/haptable-gmsh.so: reads `staged`, which errors call `file`. Packed: see unpack_model.
void haptable_gmsh_read(const std::filesystem::path& file, const std::string& staged, std::string& packed);

/// lib/haptable-cgal.so: the text of a surface. Packed: coordinates [3 P], corners [3 F].
void haptable_cgal_read(const std::filesystem::path& file, std::string_view text, haptable::SurfaceKind kind,
                        std::string& packed);

/// lib/haptable-cgal.so: the inside of a closed surface, meshed about `centre`, its edges sharper than crease_deg kept;
/// 0: none. Packed: the surface's volume, its cavities, its creases, why it failed (empty: it did not); then
/// coordinates [3 N], corners [4 E], mean length of an edge of the new surface.
void haptable_cgal_fill(const std::filesystem::path& file, const haptable::Soup& soup, const Eigen::Vector3d& centre,
                        const haptable::FillTarget& target, double crease_deg, haptable::ChildCount& count,
                        std::string& packed);

/// lib/haptable-cgal.so: a watertight surface around triangles of any kind, as fine as `target` wants it. Packed: the
/// radius of the ball, the holes that were closed, coordinates [3 P], corners [3 F]. Throws Error where they bound no
/// body.
void haptable_cgal_wrap(const std::filesystem::path& file, const haptable::Soup& soup, const Eigen::Vector3d& centre,
                        const haptable::FillTarget& target, std::string& packed);

/// lib/haptable-cgal.so: of each point from the nearest triangle. Packed: distances [points].
void haptable_cgal_distances(const haptable::Soup& soup, const std::vector<Eigen::Vector3d>& points,
                             const Eigen::Vector3d& centre, std::string& packed);
}

namespace haptable {

/// The address of `function` in lib/MODULE.so, beside the folder of this program, loaded at the first call. `file` is
/// what it is wanted for. Throws Error where there is no such module or what it needs is missing.
void* find_in_module(const std::filesystem::path& file, const char* module, const char* function);

/// Function: decltype of its declaration above.
template <typename Function>
Function* from_module(const std::filesystem::path& file, const char* module, const char* function) {
    return reinterpret_cast<Function*>(find_in_module(file, module, function));
}

}  // namespace haptable
