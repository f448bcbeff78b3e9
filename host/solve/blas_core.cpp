// SPDX-License-Identifier: GPL-2.0-or-later
// OpenBLAS picks its kernels by the processor's model number. One that is newer than the library gets kernels of 2004
// (core "Prescott": an eighth of the speed, and 0.3.21's strsm there writes over its own stack). The choice is made
// while the library loads and OPENBLAS_CORETYPE is the only way to change it: so the program starts itself once more.
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <string_view>

extern "C" char* openblas_get_corename(void);

namespace {

/// The newest kernels that this processor and its kernel can run, or null where OpenBLAS's choice is as good.
const char* better_core() {
    constexpr std::string_view kWithoutAvx[] = {"Prescott", "Core2", "Nehalem"};
    const std::string_view chosen = openblas_get_corename();
    if (std::find(std::begin(kWithoutAvx), std::end(kWithoutAvx), chosen) == std::end(kWithoutAvx)) return nullptr;
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512vl"))
        return "SkylakeX";
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") ? "Haswell" : nullptr;
}

/// Runs before main, in every program that this file is linked to; glibc hands main's arguments to it.
__attribute__((constructor)) void choose_core(int, char** arguments, char**) {
    const char* kVariable = "OPENBLAS_CORETYPE";
    if (std::getenv(kVariable) != nullptr) return;  // a user's choice, or ours
    const char* core = better_core();
    if (core == nullptr || setenv(kVariable, core, 0) != 0) return;
    execv("/proc/self/exe", arguments);  // returns only where it fails: then it is slow, as before
}

}  // namespace
