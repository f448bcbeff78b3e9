// SPDX-License-Identifier: GPL-2.0-or-later
// The report of a session: one HTML file that needs no other.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "host/run/plots.hpp"

namespace haptable {

/// A table of two columns under a heading.
struct Facts {
    std::string heading;
    std::vector<std::pair<std::string, std::string>> rows;
};

/// The rows of a program's flat JSON summary; none where it is not one.
Facts facts_of(const std::string& heading, const std::string& json);

/// `note`: what a reader must know first, such as what ended the session; may be empty.
std::string report_page(const std::string& title, const std::string& note, const std::vector<Plot>& plots,
                        const std::vector<Facts>& facts);

}  // namespace haptable
