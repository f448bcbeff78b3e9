// SPDX-License-Identifier: GPL-2.0-or-later
// Numbers without the noise that the order of a sum leaves in them: a table's float32 is then the same under any BLAS.
#pragma once

#include <cmath>

namespace haptable {

/// Bits that are kept below the leading one of a block's largest entry. A float32 of that size has 23.
constexpr int kKeptBits = 26;

/// The nearest multiple of 2^-kKeptBits of the power of two in `size`, never -0. size: largest entry of what `value`
/// is an entry of, so noise of 1e-16 to 1e-13 of it is 0; NaN and infinity stay.
inline double without_noise(double value, double size) {
    if (!(size > 0.0) || !std::isfinite(size)) return value;
    const double unit = std::ldexp(1.0, std::ilogb(size) - kKeptBits);
    return std::nearbyint(value / unit) * unit + 0.0;
}

}  // namespace haptable
