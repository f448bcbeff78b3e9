// SPDX-License-Identifier: GPL-2.0-or-later
// What every program of haptable has in common: --help, --version, one-line errors, exit status 0 only on success.
#pragma once

#include <functional>
#include <string>

#include "host/base/command_line.hpp"

namespace haptable {

/// The version of all of haptable, as in CHANGELOG.md; part of every model hash.
inline constexpr const char* kVersion = "0.1.0";

/// Parses the command line and runs `work`. Returns the exit status: 0 after `work`, 1 after an Error or any other
/// exception, 2 for a bad command line; 130 when work throws Interrupted. Errors are one line on standard error:
/// "PROGRAM: what".
int run_program(CommandLine& command_line, int argc, char** argv, const std::function<void()>& work);

}  // namespace haptable
