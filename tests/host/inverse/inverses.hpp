// SPDX-License-Identifier: GPL-2.0-or-later
// Every Inverse that this test program has: the same tests run against each.
#pragma once

#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "host/inverse/inverse.hpp"

namespace haptable::test {

struct InverseCase {
    std::string name;
    std::shared_ptr<Inverse> (*make)();
};
inline void PrintTo(const InverseCase& one, std::ostream* out) { *out << one.name; }

/// Defined beside main.
std::vector<InverseCase> inverses();

}  // namespace haptable::test
