// SPDX-License-Identifier: GPL-2.0-or-later
// libFuzzer over the readers that we wrote: whatever the bytes, an Error or a mesh, and no more memory than they ask
// for. One program a reader: HAPTABLE_FUZZ names it.
#include <unistd.h>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>

#include "host/base/error.hpp"
#include "host/mesh/readers.hpp"
#include "host/scene/scene.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

/// A folder in memory for the readers that open files by name.
const fs::path& folder() {
    static const fs::path path = [] {
        fs::path made = fs::path("/dev/shm") / ("haptable-fuzz-" + std::to_string(getpid()));
        fs::create_directories(made);
        std::atexit([] { fs::remove_all(folder()); });
        return made;
    }();
    return path;
}

void put(const fs::path& file, std::string_view text) {
    std::FILE* out = std::fopen(file.c_str(), "wb");
    if (out == nullptr) return;
    std::fwrite(text.data(), 1, text.size(), out);
    std::fclose(out);
}

[[maybe_unused]] void fuzz_abaqus(std::string_view text) { read_abaqus("a.inp", text); }
[[maybe_unused]] void fuzz_vega(std::string_view text) { read_vega("a.veg", text); }
[[maybe_unused]] void fuzz_vtu(std::string_view text) { read_vtu("a.vtu", text); }

/// Nodes, a line of '=', elements.
[[maybe_unused]] void fuzz_tetgen(std::string_view text) {
    const std::size_t cut = std::min(text.find("\n=\n"), text.size());
    put(folder() / "a.node", text.substr(0, cut));
    put(folder() / "a.ele", text.substr(std::min(cut + 3, text.size())));
    read_tetgen(folder() / "a.node");
}

[[maybe_unused]] void fuzz_scene(std::string_view text) {
    put(folder() / "a.toml", text);
    read_scene(folder() / "a.toml");
}

}  // namespace

}  // namespace haptable

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        haptable::HAPTABLE_FUZZ({reinterpret_cast<const char*>(data), size});
    } catch (const haptable::Error&) {
    }
    return 0;
}
