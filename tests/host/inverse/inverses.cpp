// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/host/inverse/inverses.hpp"

#include "host/inverse/cholmod_inverse.hpp"

namespace haptable::test {

std::vector<InverseCase> inverses() {
    return {
        {"Cholmod", []() -> std::shared_ptr<Inverse> { return std::make_shared<CholmodInverse>(1); }},
        {"CholmodWithThreeThreads", []() -> std::shared_ptr<Inverse> { return std::make_shared<CholmodInverse>(3); }}};
}

}  // namespace haptable::test
