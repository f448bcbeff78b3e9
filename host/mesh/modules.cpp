// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/mesh/modules.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include "host/base/error.hpp"
#include "host/base/installed.hpp"

namespace haptable {

void* find_in_module(const std::filesystem::path& file, const char* module, const char* function) {
    const std::filesystem::path part = find_part(fmt::format("{}.so", module));
    if (part.empty())
        throw Error(fmt::format("{}: reading it needs {}.so, which is not in {}: run make", file.string(), module,
                                (program_folder().parent_path() / "lib").string()));
    void* loaded = dlopen(part.c_str(), RTLD_LAZY | RTLD_LOCAL);
    void* address = loaded != nullptr ? dlsym(loaded, function) : nullptr;
    if (address == nullptr)
        throw Error(fmt::format("{}: reading it needs {} ({}); run make", file.string(), part.string(), dlerror()));
    return address;
}

}  // namespace haptable
