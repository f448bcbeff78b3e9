// SPDX-License-Identifier: GPL-2.0-or-later
// u_r = sum over the loaded nodes i of (L_rest)_ri F_i + sum phi_kr q_k
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "host/tables/modes.hpp"
#include "host/tables/tables.hpp"
#include "host/view/frame.hpp"

namespace haptable {

/// What the modes of a body that rings add to what is drawn.
class DrawnModes {
public:
    DrawnModes(const Tables& tables, ModeTables body_modes);

    /// displacement_m: [r,3] by the rest's columns. A frame that does not say how far the modes have swung is drawn as
    /// they come to rest under its loads. The result is valid until the next call.
    std::span<const float> add_to(std::span<const float> displacement_m, const ContactFrame& frame);

private:
    std::vector<float> at_rest(const ContactFrame& frame) const;

    ModeTables body_modes_;
    std::vector<std::int32_t> row_of_;  ///< [N] row of a mesh node, or -1
    std::vector<float> displacement_m_;
};

/// The modes of the tables in a folder; none where the body does not ring, or nothing of it is drawn.
std::optional<DrawnModes> read_drawn_modes(const Tables& tables, const TablesFolder& folder);

}  // namespace haptable
