// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <concepts>
#include <cstddef>

namespace haptable {

/// An index that is not negative, as containers take it.
constexpr std::size_t at(std::integral auto i) { return static_cast<std::size_t>(i); }

/// The first of a node's three rows, as Eigen counts them.
constexpr std::ptrdiff_t dof(std::integral auto node) { return 3 * static_cast<std::ptrdiff_t>(node); }

}  // namespace haptable
