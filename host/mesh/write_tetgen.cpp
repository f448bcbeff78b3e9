// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/mesh/write_tetgen.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/base/file.hpp"

namespace haptable {

std::filesystem::path write_tetgen(const std::vector<Eigen::Vector3d>& position, const std::vector<Tet>& tet,
                                   const std::filesystem::path& stem) {
    std::string nodes = fmt::format("{} 3 0 0\n", position.size()), tets = fmt::format("{} 4 0\n", tet.size());
    for (std::size_t i = 0; i < position.size(); ++i)
        nodes += fmt::format("{} {:.17g} {:.17g} {:.17g}\n", i, position[i][0], position[i][1], position[i][2]);
    for (std::size_t t = 0; t < tet.size(); ++t) tets += fmt::format("{} {}\n", t, fmt::join(tet[t], " "));
    if (stem.has_parent_path()) std::filesystem::create_directories(stem.parent_path());
    write_file(stem.string() + ".ele", tets);
    write_file(stem.string() + ".node", nodes);
    return stem.string() + ".node";
}

}  // namespace haptable
