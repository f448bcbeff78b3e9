// SPDX-License-Identifier: GPL-2.0-or-later
// libFuzzer over the readers that we wrote: whatever the bytes, an Error or a mesh, and no more memory than they ask
// for. Over LCM's messages too: a message or none. One program a reader: HAPTABLE_FUZZ names it.
#include <unistd.h>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/link/decode.hpp"
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

[[maybe_unused]] void fuzz_abaqus(std::string_view text) { read_abaqus({"a.inp", text}); }
[[maybe_unused]] void fuzz_vega(std::string_view text) { read_vega({"a.veg", text}); }
[[maybe_unused]] void fuzz_vtu(std::string_view text) { read_vtu({"a.vtu", text}); }

/// Nodes, a line of '=', elements.
[[maybe_unused]] void fuzz_tetgen(std::string_view text) {
    const std::size_t cut = std::min(text.find("\n=\n"), text.size());
    put(folder() / "a.node", text.substr(0, cut));
    put(folder() / "a.ele", text.substr(std::min(cut + 3, text.size())));
    read_tetgen({folder() / "a.node", ""});
}

[[maybe_unused]] void fuzz_scene(std::string_view text) {
    put(folder() / "a.toml", text);
    read_scene(folder() / "a.toml");
}

/// The bytes behind the type's hash, with lengths put in: `put` holds where, in two bytes, and which.
template <typename Message>
void fuzz_type(std::string_view put, std::string_view body) {
    constexpr std::uint32_t kLengths[] = {0,       1,          2,          0x7F,       0x8000,     0x10000,
                                          1 << 30, 0x7FFFFFFE, 0x7FFFFFFF, 0x80000000, 0x80000001, 0xFFFFFFFF};
    std::vector<std::uint8_t> bytes;
    for (int shift = 56; shift >= 0; shift -= 8)
        bytes.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(Message::getHash()) >> shift));
    bytes.insert(bytes.end(), body.begin(), body.end());
    for (; put.size() >= 3; put.remove_prefix(3)) {
        const auto byte = [&put](std::size_t i) { return static_cast<std::uint8_t>(put[i]); };
        const std::size_t at = kTypeHash_bytes + (std::size_t{byte(0)} << 8 | byte(1)) % (body.size() + 1);
        const std::uint32_t length = kLengths[byte(2) % std::size(kLengths)];
        for (std::size_t b = 0; b < 4 && at + b < bytes.size(); ++b)
            bytes[at + b] = static_cast<std::uint8_t>(length >> (24 - 8 * b));
    }
    Message message;
    if (!decode_whole(bytes, message)) return;
    std::vector<std::uint8_t> again(static_cast<std::size_t>(message.getEncodedSize()));
    if (message.encode(again.data(), 0, static_cast<int>(again.size())) != static_cast<int>(bytes.size()) ||
        again != bytes)
        std::abort();  // what was taken is not what was sent
}

/// The type, how many lengths are put in, where and which, the message behind its hash.
[[maybe_unused]] void fuzz_messages(std::string_view text) {
    if (text.size() < 2) return;
    const std::size_t lengths = std::min<std::size_t>(3 * (static_cast<std::uint8_t>(text[1]) % 4), text.size() - 2);
    const std::string_view put = text.substr(2, lengths), body = text.substr(2 + lengths);
    constexpr void (*kTypes[])(std::string_view, std::string_view) = {
        fuzz_type<contact>,   fuzz_type<servo_status>, fuzz_type<device_state>, fuzz_type<servo_force>,
        fuzz_type<body_pose>, fuzz_type<body_modes>,   fuzz_type<tool_wrench>,  fuzz_type<hand_pose>};
    kTypes[static_cast<std::uint8_t>(text[0]) % std::size(kTypes)](put, body);
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
