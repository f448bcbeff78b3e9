// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/target/image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <sstream>

#include "codegen/scene_bytes.hpp"
#include "host/base/child.hpp"
#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/shell.hpp"

namespace haptable {

namespace {

template <typename Value>
const char* take(const char* from, Value& to, std::size_t bytes = sizeof(Value)) {
    std::memcpy(&to, from, bytes);
    return from + bytes;
}

}  // namespace

TargetImage::TargetImage(std::filesystem::path build, const std::string& scene, std::string target)
    : build_(std::move(build)),
      target_(std::move(target)),
      folder_(build_ / scene / "firmware" / target_),
      is_free_(std::filesystem::exists(build_ / scene / "body.json")),
      has_tool_(std::filesystem::exists(build_ / scene / "tool.json")) {}

bool TargetTick::touches(std::size_t fingers) const {
    return std::all_of(finger.begin(), finger.begin() + static_cast<std::ptrdiff_t>(fingers),
                       [](const Finger& one) { return haptable_touches(static_cast<int>(one.state)) != 0; });
}

std::string TargetImage::missing() const {
    const std::string qemu = target_ == "rv32" ? "qemu-system-riscv32" : "qemu-system-arm";
    if (run_shell("command -v " + qemu + " 2>&1").status != 0) return qemu + " is not installed";
    const std::filesystem::path elf = folder_ / "replay.elf";
    return std::filesystem::exists(elf) ? "" : elf.string() + " is not built: make firmware TARGET=" + target_;
}

std::string TargetImage::counter(const std::string& image) const {
    constexpr std::string_view kMark = "haptable_port_count_";  // and begin, or end
    const std::filesystem::path symbols = folder_ / (image + ".sym");
    std::istringstream lines(read_file(symbols));
    std::string between;
    for (std::string address, kind, name; lines >> address >> kind >> name;)
        if (name.starts_with(kMark)) between += fmt::format(",{}=0x{}", name.substr(kMark.size()), address);
    if (std::ranges::count(between, '=') != 2)
        throw Error(symbols.string() + ": names no begin and end of what is counted: build the image again");
    return fmt::format("{}/host/target/count.so{}", build_.string(), between);
}

/// Semihosting's command line knows no blanks or commas: names are short.
TargetImage::Written TargetImage::run(const std::string& image, std::string_view bytes,
                                      const std::string& plugin) const {
    const StagedPath scratch("/tmp/haptable-image", StagedKind::folder);
    const std::filesystem::path in = scratch.path() / "in", out = scratch.path() / "out",
                                counts = scratch.path() / "counts";
    write_file(in, bytes);
    const std::string extra = plugin.empty() ? "" : fmt::format("-plugin {},out={}", plugin, counts.string());
    const std::string command =
        fmt::format("QEMU_EXTRA={} sh scripts/qemu.sh {} {} {} {}", shell_quoted(extra), target_,
                    shell_quoted(folder_ / (image + ".elf")), in.string(), out.string());
    if (const int status = run_shell(command).status; status != 0)
        throw Error(fmt::format("the image for {} ended with status {}", target_, status));
    return {read_file(out), plugin.empty() ? "" : read_file(counts)};
}

std::string TargetImage::bytes_of(const TargetScene& scene) {
    return scene_bytes(scene.model, scene.pair, scene.body, scene.body_modes, scene.tool);
}

/// Records as firmware/port/haptable_ticks.h has them; what is left of one are its modes.
std::vector<TargetTick> TargetImage::count(const std::string& image, const std::string& scene, std::string_view path,
                                           std::size_t fingers, std::size_t ticks, bool is_free) const {
    static_assert(sizeof(TargetTick::Finger) == 44);
    const auto [out, counts] = run(image, scene + std::string(path), counter(image));
    const std::size_t record = ticks > 0 ? out.size() / ticks : 0;
    const std::size_t known = fingers * sizeof(TargetTick::Finger) + (is_free ? 28 : 0);
    if (record < known || record * ticks != out.size() || record - known > sizeof TargetTick::q)
        throw Error(
            fmt::format("the image for {} wrote {} bytes for {} ticks: build it again", target_, out.size(), ticks));
    std::vector<TargetTick> made(ticks);
    std::istringstream instructions(counts);
    const char* from = out.data();
    for (TargetTick& tick : made) {
        for (std::size_t f = 0; f < fingers; ++f) from = take(from, tick.finger[f]);
        if (is_free) from = take(take(from, tick.position_m), tick.turn);
        from = take(from, tick.q, record - known);
        if (!(instructions >> tick.instructions)) throw Error("the instruction counter stopped before the image did");
    }
    return made;
}

std::vector<std::uint64_t> TargetImage::trace(std::string_view path, std::size_t tick) const {
    std::vector<std::uint64_t> addresses;
    std::istringstream lines(run("replay", path, counter("replay") + fmt::format(",trace={}", tick)).counts);
    for (std::uint64_t address = 0; lines >> std::hex >> address;) addresses.push_back(address);
    return addresses;
}

std::vector<std::array<float, 3>> TargetImage::deform(const TargetPath<3>& path_m) const {
    const std::string bytes = run("deform", bytes_of(path_m)).out;
    std::vector<std::array<float, 3>> displacement_m(bytes.size() / sizeof(std::array<float, 3>));
    std::memcpy(displacement_m.data(), bytes.data(), displacement_m.size() * sizeof displacement_m[0]);
    return displacement_m;
}

}  // namespace haptable
