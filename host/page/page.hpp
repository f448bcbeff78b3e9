// SPDX-License-Identifier: GPL-2.0-or-later
// One HTML file with all that touching a body needs: the servo as WebAssembly, its tables, columns, and what draws
// them. It opens from the disk, and asks no network for anything.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/base/modes.hpp"
#include "host/tables/tables.hpp"

namespace haptable {

/// What a page was made with.
struct PageReport {
    std::uintmax_t bytes = 0;
    std::vector<std::string> modes;
    std::string columns;        ///< "float32", "float16" or "none"
    double column_error = 0.0;  ///< of the worst column, relative; 0 for float32
};

/// The largest page that is made without being asked for, bytes.
inline constexpr double kPageBytes = 20e6;

/// The folder of what every page is made of (WebAssembly, JavaScript, three.js): lib/page beside the program's folder.
/// Throws Error that says how to make it, where it is not there.
std::filesystem::path page_parts();

struct PageText {
    std::string html;
    PageReport report;
};

/// The page of the tables in `folder`; see write_page. With `live`, ws://HOST:PORT of a PageServer, it is that of a
/// session elsewhere: it has the scene's own mode alone, and asks that server for ticks.
PageText make_page(const TablesFolder& folder, const std::filesystem::path& parts, double most_bytes = kPageBytes,
                   const std::string& live = {});

/// Writes the page of the tables in `folder` to `out`, whole or not at all. Columns are float32 where the page is then
/// at most `most_bytes`, else float16. Throws Error where it would be larger even so, or where the scene keeps a factor
/// instead of columns, and says what would help.
PageReport write_page(const TablesFolder& folder, const std::filesystem::path& parts, const std::filesystem::path& out,
                      double most_bytes = kPageBytes);

}  // namespace haptable
