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

/// For docs/STROKES.md: the totals, tables of modes, and of fingers and bodies, with each fault, a row a mesh with a
/// column a way of touching it (a cell counts the strokes with each fault), the meshes that were left out, and what was
/// stroked: source_identity of `firmware`. For docs/CONTACT.md: what is by design, and how often.
Numbers numbers_of(const CampaignResult& result, const std::filesystem::path& firmware = "firmware");
/// A hash of the C sources and headers in a folder, without comments and white space.
std::string source_identity(const std::filesystem::path& folder);
/// Every tally, for scripts.
nlohmann::ordered_json to_json(const CampaignResult& result);

/// A stroke as the servo's CSV (docs/SPEC.md), to the bits of its floats; and back.
std::string to_csv(const Stroke& stroke, int fingers);
Stroke read_stroke(const std::filesystem::path& file);

/// What the judge saw of a stroke, a line a tick and finger.
std::string to_csv(const std::vector<Judged>& ticks, int fingers);

}  // namespace haptable
