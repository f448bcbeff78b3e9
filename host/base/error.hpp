// SPDX-License-Identifier: GPL-2.0-or-later
// One line that says what is wrong, where, and what to do.
#pragma once

#include <stdexcept>
#include <string>

namespace haptable {

/// Bad input or a failed operation. The text is one line: what is wrong, where (file, line, key, node or element),
/// and what to do. A program prints it on standard error and exits with status 1.
class Error : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

}  // namespace haptable
