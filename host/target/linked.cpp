// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/target/linked.hpp"

#include <fmt/format.h>

#include <sstream>

#include "host/base/child.hpp"
#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/shell.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

constexpr const char* kCross = "arm-none-eabi-";
constexpr const char* kCore = "-mthumb -mcpu=cortex-m7 -mfpu=fpv5-sp-d16 -mfloat-abi=hard";
// As firmware/firmware.mk compiles.
constexpr const char* kFlags =
    "-std=c99 -ffreestanding -O2 -ffp-contract=off -fno-math-errno -fno-tree-loop-distribute-patterns "
    "-ffunction-sections -fdata-sections -Ifirmware";

// A tool's hand begins as a finger does. A display is there where its scene has one.
constexpr const char* kMain = R"(#include <model.h>
static HAPTABLE_MODEL_STATE state;
static HAPTABLE_MODEL_INPUT hand[HAPTABLE_MODEL_FINGERS];
static HAPTABLE_MODEL_OUTPUT felt[HAPTABLE_MODEL_FINGERS];
static volatile float device[3];
#if __has_include(<display.h>)
#include <display.h>
static float displacement_m[HAPTABLE_DISPLAY_ROWS][3];
#endif
void _start(void) {
    struct haptable_input* in = (struct haptable_input*)hand;
    struct haptable_output* out = (struct haptable_output*)felt;
    haptable_init(&HAPTABLE_MODEL_SCENE, &state);
    for (;;) {
        for (int f = 0; f < HAPTABLE_MODEL_FINGERS; ++f) {
            in[f].is_there = 1;
            in[f].finger_m[0] = device[0];
            in[f].finger_m[1] = device[1];
            in[f].finger_m[2] = device[2];
        }
        haptable_step(&HAPTABLE_MODEL_SCENE, &state, in, 0, out);
        device[0] = out[0].force_n[0];
#ifdef HAPTABLE_DISPLAY_ROWS
        haptable_deform(&HAPTABLE_DISPLAY, out, displacement_m);
#endif
    }
}
)";

/// What a command of the shell prints. Throws Error with its first line where it fails.
std::string output_of(const std::string& command) {
    ShellResult ran = run_shell(command + " 2>&1");
    if (ran.status != 0)
        throw Error(fmt::format("cannot link the servo: \"{}\" fails: {}", command.substr(0, 60),
                                ran.out.substr(0, ran.out.find('\n'))));
    return std::move(ran.out);
}

/// A file as an object in `work`.
void compile(const fs::path& tables, const fs::path& work, const fs::path& file) {
    output_of(fmt::format("{}gcc {} {} -I{} -c {} -o {}", kCross, kCore, kFlags, shell_quoted(tables),
                          shell_quoted(file), shell_quoted(work / (file.stem().string() + ".o"))));
}

}  // namespace

std::string missing_for_link(const fs::path& objects) {
    if (run_shell("command -v arm-none-eabi-gcc 2>&1").status != 0)
        return "arm-none-eabi-gcc is not installed: sh scripts/setup.sh cross";
    if (!fs::exists(objects / "haptable_scene.o")) return objects.string() + " holds no servo: make images";
    return "";
}

LinkedServo link_servo(const fs::path& tables, const fs::path& objects, const std::string& offered) {
    // Beside the tables; the linker gets it by a path from elsewhere.
    const StagedPath work(fs::absolute(tables / "linked"), StagedKind::folder);
    write_file(work.path() / "main.c", kMain);
    for (const fs::path& file : {work.path() / "main.c", tables / "model.c", tables / "display.c"})
        if (fs::exists(file)) compile(tables, work.path(), file);
    const std::string elf = (work.path() / "servo.elf").string();
    output_of(
        fmt::format("cd {} && set -- {} && {}gcc {} "
                    "-nostdlib -Wl,--gc-sections -o {} {}/*.o \"$@\" port/haptable_memory.o -lgcc",
                    shell_quoted(objects), offered, kCross, kCore, shell_quoted(elf), shell_quoted(work.path())));
    LinkedServo linked;
    std::istringstream sizes(output_of(fmt::format("{}size -A {}", kCross, shell_quoted(elf))));
    for (std::string line; std::getline(sizes, line);) {
        std::istringstream words(line);
        std::string section;
        std::size_t bytes = 0;
        if (!(words >> section >> bytes) || section.front() != '.') continue;
        if (section == ".text" || section == ".rodata" || section == ".data") linked.flash += bytes;
        if (section == ".data" || section == ".bss") linked.ram += bytes;
    }
    output_of(fmt::format("{}objcopy -O binary {} {}", kCross, shell_quoted(elf), shell_quoted(elf + ".bin")));
    linked.image = read_file(elf + ".bin");
    std::istringstream names(output_of(fmt::format("{}nm --defined-only {}", kCross, shell_quoted(elf))));
    for (std::string address, kind, name; names >> address >> kind >> name;)
        if (name.starts_with("haptable_")) linked.symbols.insert(name);
    return linked;
}

}  // namespace haptable
