// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/drawn_modes.hpp"

#include <fmt/format.h>

#include <utility>

namespace haptable {

DrawnModes::DrawnModes(const Tables& tables, ModeTables body_modes)
    : body_modes_(std::move(body_modes)), row_of_(tables.position.size(), -1) {
    for (std::size_t r = 0; r < tables.row_id.size(); ++r)
        row_of_[static_cast<std::size_t>(tables.row_id[r])] = static_cast<std::int32_t>(r);
}

/// q_k = phi_k^T f / omega_k^2
std::vector<float> DrawnModes::at_rest(const ContactFrame& frame) const {
    const std::size_t modes = body_modes_.modes();
    std::vector<float> q(modes);
    for (const NodalForce& load : frame.loads) {
        const std::int32_t row = row_of_[static_cast<std::size_t>(load.node)];
        for (std::size_t k = 0; k < modes && row >= 0; ++k)
            for (std::size_t c = 0; c < 3; ++c)
                q[k] += body_modes_.row[static_cast<std::size_t>(row) * modes + k][c] * load.force_n[c];
    }
    for (std::size_t k = 0; k < modes; ++k)
        q[k] /= static_cast<float>(body_modes_.omega_rad_per_s[k] * body_modes_.omega_rad_per_s[k]);
    return q;
}

std::span<const float> DrawnModes::add_to(std::span<const float> displacement_m, const ContactFrame& frame) {
    const std::size_t modes = body_modes_.modes();
    const std::vector<float> q = frame.modes.size() == modes ? frame.modes : at_rest(frame);
    displacement_m_.assign(displacement_m.begin(), displacement_m.end());
    for (std::size_t r = 0; r < displacement_m_.size() / 3; ++r)
        for (std::size_t k = 0; k < modes; ++k)
            for (std::size_t c = 0; c < 3; ++c) displacement_m_[3 * r + c] += body_modes_.row[r * modes + k][c] * q[k];
    return displacement_m_;
}

std::optional<DrawnModes> read_drawn_modes(const Tables& tables, const TablesFolder& folder) {
    std::optional<ModeTables> body_modes = read_modes(folder);
    if (!body_modes || body_modes->row.empty()) return {};
    if (body_modes->row.size() != tables.row_id.size() * body_modes->modes())
        folder.fail("mode_rows.npy", fmt::format("has {} rows and row_id.npy {}",
                                                 body_modes->row.size() / body_modes->modes(), tables.row_id.size()));
    return DrawnModes(tables, *std::move(body_modes));
}

}  // namespace haptable
