// SPDX-License-Identifier: GPL-2.0-or-later
// [material] and the same keys of a [[region]]: which keys there are follows from its law.
#pragma once

#include "host/base/modes.hpp"
#include "host/scene/material.hpp"
#include "host/scene/section.hpp"

namespace haptable {

/// Throws Error with line and key: a key of another law, one that is missing, or constants that no body has.
Material read_material(const Section& section, Element element);

}  // namespace haptable
