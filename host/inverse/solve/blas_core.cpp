// SPDX-License-Identifier: GPL-2.0-or-later
// OpenBLAS picks its kernels by the processor's model number. One that is newer than the library gets older kernels:
// those for AVX2 on a processor with AVX-512, or those of 2004 ("Prescott": an eighth of the speed, and 0.3.21's strsm
// there writes over its own stack). So the instructions that the processor has decide here; a race of the kernels would
// choose now one and now the other, and with them the last bits. OpenBLAS chooses while it loads and OPENBLAS_CORETYPE
// is the only way to change that: the program starts itself once more.
#include "host/inverse/solve/blas_core.hpp"

#include <cblas.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "host/base/error.hpp"

// OpenBLAS's own, which no header declares.
extern "C" {
void* blas_memory_alloc(int);
void blas_memory_free(void*);
}

namespace haptable {

namespace {

// What OpenBLAS maps for each thread on x86-64 (BUFFER_SIZE and a page), rounded up.
constexpr std::size_t kBuffer_bytes = (std::size_t{128} << 20) + (std::size_t{1} << 16);

/// Whether so many bytes could be mapped now.
bool has_room(std::size_t bytes) {
    void* tried = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return tried != MAP_FAILED && munmap(tried, bytes) == 0;
}

void require_room(int threads) {
    if (!has_room(static_cast<std::size_t>(threads) * kBuffer_bytes))
        throw Error(
            fmt::format("no room for the working memory of {} threads of OpenBLAS, {} MB each: raise the limit "
                        "of the address space (ulimit -v), or take fewer threads (OPENBLAS_NUM_THREADS=1, "
                        "--threads 1)",
                        threads, kBuffer_bytes >> 20));
}

/// What kernels of a name use. Those that are not listed are older than AVX.
struct Kernels {
    std::string_view name;
    Vectors vectors;
};
constexpr Kernels kKernels[] = {
    {"Sandybridge", Vectors::kAvx},   {"Bulldozer", Vectors::kAvx},
    {"Piledriver", Vectors::kAvx},    {"Steamroller", Vectors::kAvx},
    {"Excavator", Vectors::kAvx},     {"Haswell", Vectors::kAvx2},
    {"Zen", Vectors::kAvx2},          {"SkylakeX", Vectors::kAvx512},
    {"Cooperlake", Vectors::kAvx512}, {"SapphireRapids", Vectors::kAvx512},
};

/// What this processor has and its operating system lets it use.
Vectors vectors_of_processor() {
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512vl"))
        return Vectors::kAvx512;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return Vectors::kAvx2;
    return __builtin_cpu_supports("avx") ? Vectors::kAvx : Vectors::kSse;
}

/// Runs before main, in every program that this file is linked to; glibc hands main's arguments to it.
__attribute__((constructor)) void choose_kernels(int, char** arguments, char**) {
    const char* kVariable = "OPENBLAS_CORETYPE";
    if (std::getenv(kVariable) != nullptr) return;  // a user's choice, or ours
    const char* faster = faster_kernels(openblas_get_corename(), vectors_of_processor());
    if (faster == nullptr || setenv(kVariable, faster, 0) != 0) return;
    execv("/proc/self/exe", arguments);  // returns only where it fails: then it is slow, as before
}

/// After it, in every such program too. OpenBLAS's own threads were started when it was loaded, and may be asking for
/// their memory already: nothing here waits for them.
__attribute__((constructor)) void reserve_at_begin(int, char** arguments, char**) {
    try {
        require_room(openblas_get_num_threads());
        reserve_blas(1);
    } catch (const Error& error) {
        std::fprintf(stderr, "%s: %s\n", arguments[0], error.what());
        _exit(1);
    }
}

}  // namespace

const char* faster_kernels(std::string_view chosen, Vectors processor) {
    const auto* found =
        std::find_if(std::begin(kKernels), std::end(kKernels), [&](const Kernels& k) { return k.name == chosen; });
    const Vectors used = found == std::end(kKernels) ? Vectors::kSse : found->vectors;
    if (used >= processor) return nullptr;
    switch (processor) {
        case Vectors::kAvx512:
            return "SkylakeX";
        case Vectors::kAvx2:
            return "Haswell";
        case Vectors::kAvx:
            return "Sandybridge";
        case Vectors::kSse:
            break;
    }
    return nullptr;
}

void reserve_blas(int threads) {
    require_room(threads);
    std::vector<void*> buffer(static_cast<std::size_t>(threads));
    for (void*& one : buffer) one = blas_memory_alloc(0);
    for (void* one : buffer) blas_memory_free(one);
}

std::string blas_kernels() {
    const std::string config = openblas_get_config();  // "OpenBLAS 0.3.21 NO_LAPACKE DYNAMIC_ARCH ..."
    const std::size_t version = config.find(' ', config.find(' ') + 1);
    return std::string(openblas_get_corename()) + " of " + config.substr(0, version);
}

}  // namespace haptable
