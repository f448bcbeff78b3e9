// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "host/view/image.hpp"

namespace haptable {

/// The picture as a PNG of 8 bits a colour: same picture, same bytes.
std::string encode_png(const Image& image);

/// Writes a PNG, whole or not at all. Throws Error that names the path.
void write_png(const std::filesystem::path& path, const Image& image);

}  // namespace haptable
