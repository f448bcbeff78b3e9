// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/target/cycles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <regex>
#include <sstream>

#include "host/base/child.hpp"
#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/shell.hpp"

namespace haptable {

namespace {

/// What a shell command prints; empty when it fails.
std::string printed_by(const std::string& command) {
    ShellResult ran = run_shell(command + " 2>/dev/null");
    return ran.status == 0 ? std::move(ran.out) : std::string();
}

/// The instruction as llvm-mca takes it, with the same cost. In a trace branches lead nowhere: a target of cbz, which
/// reaches 126 bytes, may be any; a call, for which llvm-mca assumes 100 cycles, is a branch, as what it calls follows.
/// LLVM 14's Cortex-M7 knows no comparison of floats: it gets another operation of the same unit.
std::string for_mca(const std::string& instruction) {
    static const std::pair<std::regex, const char*> kSame[] = {
        {std::regex("^(\tcbn?z\t.*)0x[0-9a-f]+"), "$1#4"},
        {std::regex("^\tbl\t"), "\tb\t"},
        {std::regex("^\tblx\t"), "\tbx\t"},
        {std::regex("^\tbx\tlr"), "\tb\t#4"},
        {std::regex("^\tvcmpe?\\.f32\t(s[0-9]+),.*"), "\tvabs.f32\ts31, $1"},
    };
    std::string text = instruction;
    for (const auto& [what, by] : kSame) text = std::regex_replace(text, what, by);
    return text;
}

/// The instructions of an IT block without their conditions, and the IT itself as a nop: LLVM 14's Cortex-M7 does not
/// know it. In a trace each has run, or passed as a nop.
class ItBlocks {
public:
    std::string operator()(const std::string& instruction) {
        static const std::regex it("^\tit([te]*)\t.*"),
            condition("^\t([a-z]+)(eq|ne|hs|cs|lo|cc|mi|pl|vs|vc|hi|ls|ge|lt|gt|le)(?=[.\t])");
        std::smatch block;
        if (std::regex_match(instruction, block, it)) {
            left_ = 1 + static_cast<std::size_t>(block.length(1));
            return "\tnop";
        }
        if (left_ == 0) return instruction;
        --left_;
        return std::regex_replace(instruction, condition, "\t$1", std::regex_constants::format_first_only);
    }

private:
    std::size_t left_ = 0;
};

/// Address and text of every instruction of the image: "  1850:   \tvldr\ts15, [r2]".
std::map<std::uint64_t, std::string> disassemble(const TargetImage& image) {
    std::map<std::uint64_t, std::string> text;
    std::istringstream lines(printed_by(
        fmt::format("llvm-objdump -d --no-show-raw-insn --mcpu={} {}", image.target(), shell_quoted(image.elf()))));
    for (std::string line; std::getline(lines, line);) {
        const std::size_t tab = line.find('\t'), colon = line.find(':');
        // An instruction's line begins with its address; the file's name may hold a colon too.
        if (tab == std::string::npos || line.find_first_not_of(" 0123456789abcdef") != colon) continue;
        const std::size_t end = std::min(line.find('<', tab), line.find('@', tab));
        text[std::stoull(line, nullptr, 16)] = line.substr(tab, end - tab);
    }
    return text;
}

}  // namespace

template <std::size_t size>
std::optional<std::uint64_t> estimate_cycles(const TargetImage& image, const TargetPath<size>& path_m,
                                             std::size_t tick) {
    if (image.target() != "cortex-m4" && image.target() != "cortex-m7") return std::nullopt;
    const std::map<std::uint64_t, std::string> text = disassemble(image);
    if (text.empty()) return std::nullopt;
    std::string executed;
    ItBlocks without_conditions;
    for (const std::uint64_t address : image.trace(path_m, tick)) {
        const auto instruction = text.find(address);
        if (instruction == text.end())
            throw Error(fmt::format("{}: llvm-objdump shows no instruction at {:x}", image.elf().string(), address));
        executed += for_mca(without_conditions(instruction->second)) + "\n";
    }
    const std::filesystem::path file = image.elf().parent_path() / "tick.s";
    write_file(file, executed);
    const std::string key = "Total Cycles:";
    const std::string report = printed_by(fmt::format(
        "llvm-mca -mtriple=thumbv7em-none-eabihf -mcpu={} -iterations=1 {}", image.target(), shell_quoted(file)));
    const std::size_t at = report.find(key);
    if (at == std::string::npos) return std::nullopt;
    return std::stoull(report.substr(at + key.size()));
}

template std::optional<std::uint64_t> estimate_cycles(const TargetImage& image, const TargetPath<3>& path_m,
                                                      std::size_t tick);
template std::optional<std::uint64_t> estimate_cycles(const TargetImage& image, const TargetPath<6>& path_m,
                                                      std::size_t tick);

}  // namespace haptable
