// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/target/linked.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <sstream>

#include "host/base/error.hpp"
#include "host/base/file.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;

constexpr const char* kCross = "arm-none-eabi-";
constexpr const char* kCore = "-mthumb -mcpu=cortex-m7 -mfpu=fpv5-sp-d16 -mfloat-abi=hard";
// As firmware/firmware.mk compiles.
constexpr const char* kFlags =
    "-std=c99 -ffreestanding -O2 -ffp-contract=off -fno-math-errno -fno-tree-loop-distribute-patterns "
    "-ffunction-sections -fdata-sections -Ifirmware";

constexpr const char* kMain =
    "#include \"model.h\"\n"
    "@include@"
    "static struct haptable_servo servo;\n"
    "static struct haptable_output out;\n"
    "static volatile float device[3];\n"
    "@display@"
    "void _start(void) {\n"
    "    haptable_init(&servo);\n"
    "    @init@\n"
    "    for (;;) {\n"
    "        const float finger_m[1][3] = {{device[0], device[1], device[2]}};\n"
    "        @step@\n"
    "        device[0] = out.force_n[0];\n"
    "        @deform@\n"
    "    }\n"
    "}\n";

std::string replaced(std::string text, const std::string& what, const std::string& by) {
    return text.replace(text.find(what), what.size(), by);
}

/// How a tick of a body is asked for that is held or not, and rings or not.
struct Step {
    std::string include, init, step;
};

Step step_of(bool is_free, bool rings) {
    constexpr const char* kBody = "static struct haptable_body_state body;\n";
    constexpr const char* kBodyInit = "haptable_body_init(&HAPTABLE_MODEL_BODY, &body);";
    constexpr const char* kModes = "static struct haptable_modes_state swings;\n";
    constexpr const char* kModesInit = "haptable_modes_init(&swings);";
    if (is_free && rings)
        return {std::string("#include \"haptable_body_modes.h\"\n") + kBody + kModes,
                std::string(kBodyInit) + kModesInit,
                "haptable_body_modes_step(HAPTABLE_MODEL_MODES, &HAPTABLE_MODEL_BODY, &body, &swings, &servo, "
                "finger_m[0], 0, &out);"};
    if (is_free)
        return {kBody, kBodyInit,
                "haptable_body_step(&HAPTABLE_MODEL, &HAPTABLE_MODEL_BODY, &body, &servo, 1, finger_m, 0, &out);"};
    if (rings)
        return {kModes, kModesInit,
                "haptable_modes_step(HAPTABLE_MODEL_MODES, &swings, &servo, finger_m[0], 0, &out);"};
    return {"", "", "haptable_step(&HAPTABLE_MODEL, &servo, finger_m[0], 0, &out);"};
}

std::string main_text(const fs::path& tables) {
    const bool display = fs::exists(tables / "display.c");
    const Step step = step_of(fs::exists(tables / "body.json"), fs::exists(tables / "modes.json"));
    const std::string rows = "#include \"display.h\"\nstatic float displacement_m[HAPTABLE_DISPLAY_ROWS][3];\n";
    std::string text = kMain;
    text = replaced(text, "@include@", step.include);
    text = replaced(text, "@init@", step.init);
    text = replaced(text, "@step@", step.step);
    text = replaced(text, "@display@", display ? rows : "");
    return replaced(text, "@deform@", display ? "haptable_deform(&HAPTABLE_DISPLAY, &out, displacement_m);" : "");
}

/// What a command of the shell prints. Throws Error with its last line where it fails.
std::string output_of(const std::string& command) {
    std::FILE* const pipe = popen((command + " 2>&1").c_str(), "r");
    std::string out;
    char some[4096];
    for (std::size_t n = 0; pipe != nullptr && (n = std::fread(some, 1, sizeof some, pipe)) > 0;) out.append(some, n);
    if (pipe == nullptr || pclose(pipe) != 0)
        throw Error(fmt::format("cannot link the servo: \"{}\" fails: {}", command.substr(0, 60),
                                out.substr(0, out.find('\n'))));
    return out;
}

/// model.c of the tables as an object in `work`.
void compile(const fs::path& tables, const fs::path& work, const std::string& file) {
    output_of(fmt::format("{}gcc {} {} -I'{}' -c '{}' -o '{}.o'", kCross, kCore, kFlags, tables.string(), file,
                          (work / fs::path(file).stem()).string()));
}

/// Objects in a folder beside the tables, gone with this object.
class Work {
public:
    explicit Work(const fs::path& tables) : path_(fs::absolute(tables / "linked")) { fs::create_directories(path_); }
    ~Work() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    Work(const Work&) = delete;
    Work& operator=(const Work&) = delete;
    const fs::path& path() const { return path_; }

private:
    fs::path path_;
};

}  // namespace

std::string missing_for_link(const fs::path& objects) {
    if (std::system("command -v arm-none-eabi-gcc >/dev/null 2>&1") != 0)
        return "arm-none-eabi-gcc is not installed: sh scripts/setup.sh cross";
    if (!fs::exists(objects / "haptable_servo.o")) return objects.string() + " holds no servo: make images";
    return "";
}

LinkedServo link_servo(const fs::path& tables, const fs::path& objects, const std::string& offered) {
    const Work work(tables);
    const bool display = fs::exists(tables / "display.c");
    write_file(work.path() / "main.c", main_text(tables));
    compile(tables, work.path(), (work.path() / "main.c").string());
    compile(tables, work.path(), (tables / "model.c").string());
    if (display) compile(tables, work.path(), (tables / "display.c").string());
    const std::string elf = (work.path() / "servo.elf").string();
    output_of(
        fmt::format("cd '{}' && set -- {} && {}gcc {} "
                    "-nostdlib -Wl,--gc-sections -o '{}' '{}'/*.o \"$@\" port/haptable_memory.o -lgcc",
                    objects.string(), offered, kCross, kCore, elf, work.path().string()));
    LinkedServo linked;
    std::istringstream sizes(output_of(fmt::format("{}size -A '{}'", kCross, elf)));
    for (std::string line; std::getline(sizes, line);) {
        std::istringstream words(line);
        std::string section;
        std::size_t bytes = 0;
        if (!(words >> section >> bytes) || section.front() != '.') continue;
        if (section == ".text" || section == ".rodata" || section == ".data") linked.flash += bytes;
        if (section == ".data" || section == ".bss") linked.ram += bytes;
    }
    output_of(fmt::format("{0}objcopy -O binary '{1}' '{1}.bin'", kCross, elf));
    linked.image = read_file(elf + ".bin");
    std::istringstream names(output_of(fmt::format("{}nm --defined-only '{}'", kCross, elf)));
    for (std::string address, kind, name; names >> address >> kind >> name;)
        if (name.starts_with("haptable_")) linked.symbols.insert(name);
    return linked;
}

std::size_t stack_of(const fs::path& tables, const fs::path& objects) {
    const Work work(tables);
    compile(tables, work.path(), (tables / "model.c").string());
    return std::stoul(output_of(fmt::format("CROSS={} sh scripts/stack.sh '{}' '{}'", kCross, objects.string(),
                                            (work.path() / "model.o").string())));
}

}  // namespace haptable
