// SPDX-License-Identifier: GPL-2.0-or-later
// The device that a pointer's hand holds.
#pragma once

#include "host/device/point_device.hpp"
#include "host/tables/tables.hpp"

namespace haptable {

/// The scene's device by the figures in its tables: mass, damping, friction, encoder, limit. It is at the body, without
/// scales, delay and lag.
Device pointer_device(const Tables& tables, const TablesFolder& folder);

}  // namespace haptable
