// SPDX-License-Identifier: GPL-2.0-or-later
// Smooth outlines of a picture that was drawn with one sample a pixel: steps of an edge are found by their length, and
// the pixels along a step are mixed by the share that the straight edge would cover of them. After A. Reshetov,
// "Morphological antialiasing", High Performance Graphics 2009, on brightness alone.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/view/image.hpp"

namespace haptable {

/// Keeps its work space from picture to picture.
class Smoothing {
public:
    /// Smooths the pixels of `box`. What stands outside of it is looked at and left as it is.
    void run(Image& image, const PixelBox& box);

private:
    struct Mix {
        std::size_t pixel;
        std::uint32_t color;
    };
    using Mixes = std::vector<Mix>;

    void find_brightness(const Image& image);
    int brightness(std::ptrdiff_t at) const { return brightness_[static_cast<std::size_t>(at)]; }
    /// Looks at rows from .. to - 1; they only read what is shared.
    void look_at_rows(const Image& image, int from, int to, Mixes& mixes) const;
    void look_at(const Image& image, int x, int y, Mixes& mixes) const;
    static void mix(const Image& image, std::ptrdiff_t at, std::ptrdiff_t towards, int share_256, Mixes& mixes);

    int left_ = 0, top_ = 0, right_ = 0, bottom_ = 0;  ///< of what is smoothed
    std::vector<std::uint8_t> brightness_;             ///< [height, width]
    std::array<Mixes, 2> mixes_;                       ///< of the upper and of the lower half
};

}  // namespace haptable
