// SPDX-License-Identifier: GPL-2.0-or-later
// colour(t): a curve through Oklab, parametrised by its own length
// B. Ottosson, "A perceptual color space for image processing", 2020 (the two matrices below).
#include "host/view/colormap.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace haptable {

namespace {

using Triple = std::array<double, 3>;

constexpr std::size_t kSamples = 4096;  // of the curve, to measure its length

/// The curve in lightness, chroma and hue (degrees), each linear or quadratic in its parameter 0 .. 1.
Triple oklab(double s) {
    const double lightness = 0.45 + 0.48 * s;
    const double chroma = 0.115 + 0.035 * s + 0.022 * std::cos(2.0 * std::numbers::pi * s);
    const double hue = (285.0 - 177.0 * s) * std::numbers::pi / 180.0;
    return {lightness, chroma * std::cos(hue), chroma * std::sin(hue)};
}

double srgb(double linear) {
    const double c = std::clamp(linear, 0.0, 1.0);
    return c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1.0 / 2.4) - 0.055;
}

Rgb8 to_rgb(const Triple& lab) {
    const double l = std::pow(lab[0] + 0.3963377774 * lab[1] + 0.2158037573 * lab[2], 3.0);
    const double m = std::pow(lab[0] - 0.1055613458 * lab[1] - 0.0638541728 * lab[2], 3.0);
    const double s = std::pow(lab[0] - 0.0894841775 * lab[1] - 1.2914855480 * lab[2], 3.0);
    const Triple linear{4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
                        -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
                        -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s};
    Rgb8 out;
    for (std::size_t c = 0; c < 3; ++c) out[c] = static_cast<std::uint8_t>(std::lround(255.0 * srgb(linear[c])));
    return out;
}

std::array<Rgb8, kColors> make_map() {
    std::vector<double> length(kSamples + 1, 0.0);  // of the curve up to each sample
    Triple before = oklab(0.0);
    for (std::size_t i = 1; i <= kSamples; ++i) {
        const Triple here = oklab(static_cast<double>(i) / kSamples);
        length[i] = length[i - 1] + std::hypot(here[0] - before[0], here[1] - before[1], here[2] - before[2]);
        before = here;
    }
    std::array<Rgb8, kColors> map;
    for (std::size_t k = 0; k < kColors; ++k) {
        const double wanted = length.back() * static_cast<double>(k) / (kColors - 1);
        const auto at = std::lower_bound(length.begin(), length.end(), wanted);
        map[k] = to_rgb(oklab(static_cast<double>(std::distance(length.begin(), at)) / kSamples));
    }
    return map;
}

}  // namespace

const std::array<Rgb8, kColors>& color_map() {
    static const std::array<Rgb8, kColors> map = make_map();
    return map;
}

}  // namespace haptable
