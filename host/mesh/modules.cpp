// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/mesh/modules.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include "host/base/error.hpp"

namespace haptable {

void* find_in_module(const std::filesystem::path& file, const char* module, const char* function) {
    // The linker was given the folder: lib/ beside the program's own (the Makefile's MODULES).
    void* loaded = dlopen(fmt::format("{}.so", module).c_str(), RTLD_LAZY | RTLD_LOCAL);
    void* address = loaded != nullptr ? dlsym(loaded, function) : nullptr;
    if (address == nullptr)
        throw Error(fmt::format("{}: reading it needs lib/{}.so ({}); run make", file.string(), module, dlerror()));
    return address;
}

}  // namespace haptable
