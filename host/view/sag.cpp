// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/sag.hpp"

#include <fmt/format.h>

#include "host/base/error.hpp"
#include "host/tables/npy.hpp"

namespace haptable {

Sag read_sag(Tables tables, const TablesFolder& folder) {
    if (folder.has("body.json"))
        throw Error(folder.text() + ": has no sag: a free body falls, and its weight does not deform it");
    if (!folder.has("sag.npy"))
        throw Error(folder.text() + ": has no sag: give the scene a [gravity] and make the tables again");
    const MappedNpy<double> sag_m(folder.file("sag.npy"));
    if (sag_m.shape() != std::vector<std::size_t>{tables.position.size(), 3})
        folder.fail("sag.npy", fmt::format("does not have the {} nodes of position.npy", tables.position.size()));
    Sag sag{std::move(tables), {}};
    sag.tables.patch = sag.tables.surface;
    sag.tables.row_id.clear();
    for (std::size_t i = 0; i < sag.tables.position.size(); ++i) {
        const double* u = &sag_m.values()[3 * i];
        if (u[0] == 0.0 && u[1] == 0.0 && u[2] == 0.0) continue;  // held
        sag.tables.row_id.push_back(static_cast<std::int32_t>(i));
        for (std::size_t c = 0; c < 3; ++c) {
            sag.tables.position[i][c] -= u[c];
            sag.displacement_m.push_back(static_cast<float>(u[c]));
        }
    }
    return sag;
}

}  // namespace haptable
