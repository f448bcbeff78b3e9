// SPDX-License-Identifier: GPL-2.0-or-later
// What is written over a finished picture: title, legend, scale bar, the force at its arrow.
#pragma once

#include <cairo.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "host/view/colormap.hpp"
#include "host/view/image.hpp"

namespace haptable {

struct LegendEntry {
    enum class Sign { dot, arrow, area };
    std::string text;
    Rgb8 color;
    Sign sign = Sign::dot;
};

/// A straight line of the picture, in pixels.
struct NoteLine {
    Eigen::Vector2f from_px, to_px;
    Rgb8 color;
};

/// A word at a point of the picture.
struct NoteTag {
    Eigen::Vector2f at_px;
    std::string text;
    Rgb8 color;
};

/// The colours' scale: "displacement (mm)" from 0 to `range`.
struct ColorBar {
    std::string name;
    double range = 0.0;  ///< 0: no bar
};

struct Annotation {
    std::string title;                 ///< heavy, at the top left
    std::vector<std::string> details;  ///< light, in columns after the title
    std::string second;                ///< light, in the line under the title
    std::string warning;               ///< there, in red; empty: none
    std::vector<LegendEntry> legend;   ///< at the bottom left
    ColorBar bar;
    double px_per_m = 0.0;                ///< at the body's middle, for a bar of length; 0: none
    std::optional<Eigen::Matrix3f> axes;  ///< columns: x y z of the body as the eye sees them, right, up, towards it
    std::vector<NoteLine> lines;
    std::vector<NoteTag> tags;
    std::string label;  ///< at a point of the picture, for the arrow
    std::optional<Eigen::Vector2f> label_px;
    Eigen::Vector2f label_direction{0.0F, 0.0F};  ///< along the arrow: the label stands clear of it
};

void annotate(Image& image, const Annotation& annotation);
/// The same on any surface of cairo's, in pixels of `width` x `height`.
void annotate(cairo_t* cairo, int width, int height, const Annotation& annotation);

/// The largest of 1, 2, 5 times a power of ten that puts at least `steps` steps into `range`.
double nice_step(double range, int steps);

}  // namespace haptable
