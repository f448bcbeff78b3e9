// SPDX-License-Identifier: GPL-2.0-or-later
// The picture as vectors, for a paper: SVG or PDF.
#pragma once

#include <filesystem>

#include "host/view/annotate.hpp"
#include "host/view/renderer.hpp"

namespace haptable {

/// True for the suffixes that draw_figure knows: .svg and .pdf.
bool is_figure(const std::filesystem::path& path);

/// Patches from the farthest to the nearest, each divided until its colours are even to the eye; markers, then notes
/// over them. One pixel is one point (1/72 inch). Written beside, then renamed. Throws Error that names the path.
void draw_figure(const std::filesystem::path& path, const ViewOptions& view, const Camera& camera, float size_m,
                 const DrawnSurface& surface, const Shading& shading, const Markers& markers, const Annotation& notes);

}  // namespace haptable
