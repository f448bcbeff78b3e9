// SPDX-License-Identifier: GPL-2.0-or-later
// Text with named places: how generated files look, apart from what they hold.
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace haptable {

/// What a template may ask for, by name.
using TemplateValues = std::map<std::string, std::string, std::less<>>;

/// The text with its values: of "@name@" the value, of the lines between "@if name" and "@end" those before an "@else"
/// where the value is not empty, else those behind it. A line that is a place alone ends with its value's last line,
/// and vanishes where that is empty. Throws Error for a name that has no value.
std::string filled(std::string_view text, const TemplateValues& values);

}  // namespace haptable
