// SPDX-License-Identifier: GPL-2.0-or-later
// Base64 (RFC 4648, section 4): bytes as text.
#pragma once

#include <string>
#include <string_view>

namespace haptable {

std::string to_base64(std::string_view bytes);

}  // namespace haptable
