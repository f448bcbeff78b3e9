// SPDX-License-Identifier: GPL-2.0-or-later
// A campaign's counts as JSON, and strokes as files.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/strokes/campaign.hpp"

namespace haptable {

/// Every tally of every body, and what each mode is: lab/strokes.py makes the pages' tables of it.
nlohmann::ordered_json to_json(const CampaignResult& result);

/// A stroke as the servo's CSV (docs/SPEC.md), to the bits of its floats; and back. fingers: 1, 2, or kToolHand.
constexpr int kToolHand = 0;
std::string to_csv(const Stroke& stroke, int fingers);
Stroke read_stroke(const std::filesystem::path& file);

/// What the judge saw of a stroke, a line a tick and finger or point of a tool.
std::string to_csv(const std::vector<Judged>& ticks, std::size_t contacts);

}  // namespace haptable
