// SPDX-License-Identifier: GPL-2.0-or-later
// Packages of PyPI for tests that run without a network; scripts/python.sh brings them (make build/python/ready).
#pragma once

#include <filesystem>

#include "tests/process.hpp"

namespace haptable::test {

inline constexpr const char* kNoWheels = "the packages of PyPI are not there: make test installs them";

inline bool has_wheels() { return std::filesystem::exists(build_folder() / "python/ready"); }

}  // namespace haptable::test
