// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/inverse/solve/blas_core.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

namespace haptable {

namespace {

// OpenBLAS 0.3.21 takes Haswell's on a Sapphire Rapids, a third slower than SkylakeX's there; and Prescott's on
// whatever it does not know.
TEST(BlasKernels, OlderOnesThanTheProcessorsAreReplaced) {
    EXPECT_STREQ(faster_kernels("Haswell", Vectors::kAvx512), "SkylakeX");
    EXPECT_STREQ(faster_kernels("Prescott", Vectors::kAvx512), "SkylakeX");
    EXPECT_STREQ(faster_kernels("Prescott", Vectors::kAvx2), "Haswell");
    EXPECT_STREQ(faster_kernels("Nehalem", Vectors::kAvx), "Sandybridge");
}

TEST(BlasKernels, AsGoodOnesAndThoseOfAnOldProcessorStay) {
    for (const char* name : {"SkylakeX", "Cooperlake", "SapphireRapids"})
        EXPECT_EQ(faster_kernels(name, Vectors::kAvx512), nullptr) << name;
    EXPECT_EQ(faster_kernels("Zen", Vectors::kAvx2), nullptr);
    EXPECT_EQ(faster_kernels("Core2", Vectors::kSse), nullptr);
}

TEST(BlasKernels, AreThoseThatWereAskedFor) {
    const char* asked = std::getenv("OPENBLAS_CORETYPE");
    const std::string kernels = blas_kernels();
    printf("computes with %s\n", kernels.c_str());  // scripts/test-kernels.sh reads it
    EXPECT_NE(kernels.find(" of OpenBLAS 0."), std::string::npos) << kernels;
    if (asked != nullptr) {
        EXPECT_EQ(kernels.substr(0, kernels.find(' ')), asked);
    }
}

}  // namespace

}  // namespace haptable
