// SPDX-License-Identifier: GPL-2.0-or-later
// Which of OpenBLAS's kernels this program computes with.
#pragma once

#include <string>
#include <string_view>

namespace haptable {

/// Generations of vector instructions that kernels are written for.
enum class Vectors { kSse, kAvx, kAvx2, kAvx512 };

/// The name of faster kernels than the `chosen` ones for a processor with these instructions, or null.
const char* faster_kernels(std::string_view chosen, Vectors processor);

/// What computes: "SkylakeX of OpenBLAS 0.3.21".
std::string blas_kernels();

/// Takes the working memory of as many threads that call BLAS at once, which stays for them. Throws Error where there
/// is no room: OpenBLAS itself would ask for it again and again, without end. Called before main for OpenBLAS's own.
void reserve_blas(int threads);

}  // namespace haptable
