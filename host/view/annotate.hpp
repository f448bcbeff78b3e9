// SPDX-License-Identifier: GPL-2.0-or-later
// What is written over a finished picture: title, legend, scale bar, the force at its arrow.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "host/view/colormap.hpp"
#include "host/view/image.hpp"

namespace haptable {

struct LegendEntry {
    std::string text;
    Rgb8 color;
    bool arrow = false;  ///< a stroke instead of a dot
};

struct Annotation {
    std::string title;                 ///< heavy, at the top left
    std::vector<std::string> details;  ///< light, in columns after the title
    std::string warning;               ///< under the title, in red; empty: none
    std::vector<LegendEntry> legend;   ///< at the bottom left
    double range_mm = 0.0;             ///< of the scale bar; 0: none
    std::string label;                 ///< at a point of the picture, for the arrow
    std::optional<Eigen::Vector2f> label_px;
    Eigen::Vector2f label_direction{0.0F, 0.0F};  ///< along the arrow: the label stands clear of it
};

void annotate(Image& image, const Annotation& annotation);

/// The largest of 1, 2, 5 times a power of ten that puts at least `steps` steps into `range`.
double nice_step(double range, int steps);

}  // namespace haptable
