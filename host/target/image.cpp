// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/target/image.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <bit>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "codegen/model_bytes.hpp"
#include "codegen/pair.hpp"
#include "host/base/error.hpp"
#include "host/base/file.hpp"

namespace haptable {

namespace {

/// Files of one run, gone with this object. Semihosting's command line knows no blanks or commas: names are short.
class Scratch {
public:
    Scratch() {
        char name[] = "/tmp/haptable-XXXXXX";
        if (mkdtemp(name) == nullptr) throw Error("cannot make a folder in /tmp: is it full?");
        path_ = name;
    }
    ~Scratch() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;

    std::filesystem::path operator/(const char* name) const { return path_ / name; }

private:
    std::filesystem::path path_;
};

/// The first positions of a path, as an image reads them.
std::string_view bytes_of(const std::vector<std::array<float, 3>>& path_m, std::size_t ticks) {
    return {reinterpret_cast<const char*>(path_m.data()), ticks * sizeof path_m[0]};
}

bool has_command(const std::string& name) {
    return std::system(("command -v " + name + " >/dev/null 2>&1").c_str()) == 0;
}

std::array<float, 3> floats(std::istream& line) {
    std::array<float, 3> values{};
    for (float& value : values) {
        std::uint32_t bits = 0;
        line >> std::hex >> bits;
        value = std::bit_cast<float>(bits);
    }
    return values;
}

std::vector<TargetTick> parse(const std::string& text) {
    std::vector<TargetTick> ticks;
    std::istringstream lines(text);
    for (std::string one; std::getline(lines, one);) {
        std::istringstream line(one);
        TargetTick tick;
        line >> std::hex >> tick.state >> tick.vertex[0] >> tick.vertex[1] >> tick.vertex[2];
        tick.alpha = floats(line);
        tick.god_object_m = floats(line);
        tick.force_n = floats(line);
        if (!line) throw Error(fmt::format("the image printed no tick but \"{}\": build it again", one));
        ticks.push_back(tick);
    }
    return ticks;
}

template <typename Tick>
void add_counts(const std::string& text, std::vector<Tick>& ticks) {
    std::istringstream counts(text);
    for (Tick& tick : ticks)
        if (!(counts >> tick.instructions)) throw Error("the instruction counter stopped before the image did");
}

}  // namespace

TargetImage::TargetImage(std::filesystem::path build, const std::string& scene, std::string target)
    : build_(std::move(build)), target_(std::move(target)), folder_(build_ / scene / "firmware" / target_) {}

std::string TargetImage::missing() const {
    const std::string qemu = target_ == "rv32" ? "qemu-system-riscv32" : "qemu-system-arm";
    if (!has_command(qemu)) return qemu + " is not installed";
    if (!std::filesystem::exists(folder_ / "replay.elf"))
        return (folder_ / "replay.elf").string() + " is not built: make firmware TARGET=" + target_;
    return {};
}

std::string TargetImage::address_of(const std::string& image, const std::string& symbol) const {
    const std::filesystem::path symbols = folder_ / (image + ".sym");
    std::istringstream lines(read_file(symbols));
    for (std::string address, kind, name; lines >> address >> kind >> name;)
        if (name == symbol) return "0x" + address;
    throw Error(symbols.string() + " does not name " + symbol + ": build the image again");
}

std::string TargetImage::run_counted(const std::string& image, std::string_view bytes,
                                     const std::string& more_of_plugin, std::string& out) const {
    const Scratch scratch;
    write_file(scratch / "in", bytes);
    const std::string plugin =
        fmt::format("-plugin {}/host/target/count.so,begin={},end={},out={}{}", build_.string(),
                    address_of(image, "haptable_port_count_begin"), address_of(image, "haptable_port_count_end"),
                    (scratch / "counts").string(), more_of_plugin);
    const std::string command =
        fmt::format("QEMU_EXTRA='{}' sh scripts/qemu.sh {} '{}' {} {}", plugin, target_,
                    (folder_ / (image + ".elf")).string(), (scratch / "in").string(), (scratch / "out").string());
    const int status = std::system(command.c_str());
    if (status != 0) throw Error(fmt::format("the image for {} ended with status {}", target_, status / 256));
    out = read_file(scratch / "out");
    return read_file(scratch / "counts");
}

std::vector<TargetTick> TargetImage::count(const std::string& image, std::string_view bytes, std::size_t ticks) const {
    std::string out;
    const std::string counts = run_counted(image, bytes, "", out);
    std::vector<TargetTick> made = parse(out);
    if (made.size() != ticks)
        throw Error(fmt::format("the image for {} made {} ticks of {}", target_, made.size(), ticks));
    add_counts(counts, made);
    return made;
}

std::vector<TargetTick> TargetImage::replay(const std::vector<std::array<float, 3>>& path_m) const {
    return count("replay", bytes_of(path_m, path_m.size()), path_m.size());
}

std::vector<TargetTick> TargetImage::measure(const haptable_model& model,
                                             const std::vector<std::array<float, 3>>& path_m) const {
    return count("measure", model_bytes(model) + std::string(bytes_of(path_m, path_m.size())), path_m.size());
}

std::vector<PairTargetTick> TargetImage::measure_pair(const haptable_pair_model& pair,
                                                      const std::vector<std::array<float, 6>>& path_m) const {
    using Fingers = decltype(PairTargetTick::finger);
    const std::string_view path(reinterpret_cast<const char*>(path_m.data()), path_m.size() * sizeof path_m[0]);
    std::string out;
    const std::string counts =
        run_counted("measure_pair", model_bytes(*pair.model) + coupling_bytes(pair) + std::string(path), "", out);
    if (out.size() != path_m.size() * sizeof(Fingers))
        throw Error(
            fmt::format("the image for {} made {} ticks of {}", target_, out.size() / sizeof(Fingers), path_m.size()));
    std::vector<PairTargetTick> ticks(path_m.size());
    for (std::size_t i = 0; i < ticks.size(); ++i)
        std::memcpy(&ticks[i].finger, out.data() + i * sizeof(Fingers), sizeof(Fingers));
    add_counts(counts, ticks);
    return ticks;
}

std::vector<std::uint64_t> TargetImage::trace(const std::vector<std::array<float, 3>>& path_m, std::size_t tick) const {
    std::string out;
    std::vector<std::uint64_t> addresses;
    std::istringstream lines(run_counted("replay", bytes_of(path_m, tick + 1), fmt::format(",trace={}", tick), out));
    for (std::uint64_t address = 0; lines >> std::hex >> address;) addresses.push_back(address);
    return addresses;
}

std::vector<std::array<float, 3>> TargetImage::deform(const std::vector<std::array<float, 3>>& path_m) const {
    const std::string bytes = run("deform", bytes_of(path_m, path_m.size()));
    std::vector<std::array<float, 3>> displacement_m(bytes.size() / sizeof(std::array<float, 3>));
    std::memcpy(displacement_m.data(), bytes.data(), displacement_m.size() * sizeof displacement_m[0]);
    return displacement_m;
}

template <std::size_t size, std::size_t path_size>
std::vector<NumbersTick<size>> TargetImage::numbers(const std::string& image,
                                                    const std::vector<std::array<float, path_size>>& path_m) const {
    constexpr std::size_t kBytes = size * sizeof(float);
    const std::string_view path(reinterpret_cast<const char*>(path_m.data()), path_m.size() * sizeof path_m[0]);
    std::string out;
    const std::string counts = run_counted(image, path, "", out);
    if (out.size() != path_m.size() * kBytes)
        throw Error(fmt::format("the image for {} made {} ticks of {}", target_, out.size() / kBytes, path_m.size()));
    std::vector<NumbersTick<size>> ticks(path_m.size());
    for (std::size_t i = 0; i < ticks.size(); ++i) std::memcpy(&ticks[i].value, out.data() + i * kBytes, kBytes);
    add_counts(counts, ticks);
    return ticks;
}

std::vector<NumbersTick<10>> TargetImage::move_body(const std::vector<std::array<float, 3>>& path_m) const {
    return numbers<10>("body", path_m);
}

std::vector<NumbersTick<13>> TargetImage::move_body_by_two(const std::vector<std::array<float, 6>>& path_m) const {
    return numbers<13>("grasp", path_m);
}

std::vector<NumbersTick<6>> TargetImage::ring(const std::vector<std::array<float, 3>>& path_m) const {
    return numbers<6>("modes", path_m);
}

std::vector<NumbersTick<12>> TargetImage::ring_by_two(const std::vector<std::array<float, 6>>& path_m) const {
    return numbers<12>("modes_pair", path_m);
}

std::vector<NumbersTick<13>> TargetImage::move_ringing_body_by_two(
    const std::vector<std::array<float, 6>>& path_m) const {
    return numbers<13>("grasp_modes", path_m);
}

std::string TargetImage::loop(std::string_view bytes) const { return run("loop", bytes); }

std::string TargetImage::run(const std::string& image, std::string_view bytes) const {
    const Scratch scratch;
    write_file(scratch / "in", bytes);
    const std::string command =
        fmt::format("sh scripts/qemu.sh {} '{}' {} {}", target_, (folder_ / (image + ".elf")).string(),
                    (scratch / "in").string(), (scratch / "out").string());
    const int status = std::system(command.c_str());
    if (status != 0) throw Error(fmt::format("the image for {} ended with status {}", target_, status / 256));
    return read_file(scratch / "out");
}

}  // namespace haptable
