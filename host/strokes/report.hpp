// SPDX-License-Identifier: GPL-2.0-or-later
// What a campaign found: numbers for a page, JSON for scripts, strokes as files.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/numbers/numbers.hpp"
#include "host/strokes/campaign.hpp"

namespace haptable {

/// For docs/STROKES.md: the totals, a table of modes and faults, a row a body with a column a mode, without friction
/// and with it (a cell counts the strokes with each fault), and the meshes that were left out. For docs/CONTACT.md:
/// what is by design, and how often.
Numbers numbers_of(const CampaignResult& result);
/// Every tally, for scripts.
nlohmann::ordered_json to_json(const CampaignResult& result);

/// A stroke as the servo's CSV (docs/SPEC.md), to the bits of its floats; and back.
std::string to_csv(const Stroke& stroke);
Stroke read_stroke(const std::filesystem::path& file);

/// What the judge saw of a stroke, a line a tick.
std::string to_csv(const Stroke& stroke, const std::vector<Judged>& ticks);

}  // namespace haptable
