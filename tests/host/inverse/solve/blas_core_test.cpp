// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/inverse/solve/blas_core.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/error_of.hpp"

namespace haptable {
namespace {

// OpenBLAS 0.3.21 takes Haswell's on a Sapphire Rapids, a third slower than SkylakeX's there; and Prescott's on
// whatever it does not know. As good ones and those of an old processor stay.
TEST(BlasKernels, OlderOnesThanTheProcessorsAreReplaced) {
    for (const auto& [name, vectors, faster] : {std::tuple("Haswell", Vectors::kAvx512, "SkylakeX"),
                                                {"Prescott", Vectors::kAvx512, "SkylakeX"},
                                                {"Prescott", Vectors::kAvx2, "Haswell"},
                                                {"Nehalem", Vectors::kAvx, "Sandybridge"},
                                                {"SkylakeX", Vectors::kAvx512, nullptr},
                                                {"Cooperlake", Vectors::kAvx512, nullptr},
                                                {"SapphireRapids", Vectors::kAvx512, nullptr},
                                                {"Zen", Vectors::kAvx2, nullptr},
                                                {"Core2", Vectors::kSse, nullptr}})
        EXPECT_STREQ(faster_kernels(name, vectors), faster) << name;
}

TEST(BlasKernels, AreThoseThatWereAskedFor) {
    const char* asked = std::getenv("OPENBLAS_CORETYPE");
    const std::string kernels = blas_kernels();
    printf("computes with %s\n", kernels.c_str());  // scripts/test-kernels.sh reads it
    EXPECT_TRUE(test::says(kernels, " of OpenBLAS 0."));
    if (asked != nullptr) {
        EXPECT_EQ(kernels.substr(0, kernels.find(' ')), asked);
    }
}

}  // namespace
}  // namespace haptable
