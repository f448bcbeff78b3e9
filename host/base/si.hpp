// SPDX-License-Identifier: GPL-2.0-or-later
// Numbers with a unit for people: three digits and a prefix.
#pragma once

#include <string>

namespace haptable {

/// "1.16 mN", "0 N": three digits, prefixes from nano to mega. unit: without a prefix.
std::string si(double value, const char* unit);

}  // namespace haptable
