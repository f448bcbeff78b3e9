// SPDX-License-Identifier: GPL-2.0-or-later
// Packages of PyPI for tests that run without a network: scripts/python.sh brought them (make build/python/ready).
#pragma once

#include <filesystem>
#include <string>

#include "tests/process.hpp"

namespace haptable::test {

inline constexpr const char* kNoWheels = "the packages of PyPI are not there: make test installs them";

inline bool has_wheels() { return std::filesystem::exists(build_folder() / "python/ready"); }

/// Before a command line that calls pip, here or below: it finds what it needs there, and nowhere else.
inline std::string pip_of_wheels() {
    return "PIP_NO_INDEX=1 PIP_FIND_LINKS=" + std::filesystem::absolute(build_folder() / "python/wheels").string() +
           " ";
}

}  // namespace haptable::test
