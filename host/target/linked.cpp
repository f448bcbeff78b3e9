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

// What firmware/firmware.mk compiled the objects with, but for warnings. Then bytes by section, and names.
constexpr const char* kLink = R"(set -e
tables={} work={} objects={}
compile="$(sed 's/ -MMD.*//' "$objects/options") -w"
for file in "$work/main.c" "$tables/model.c" "$tables/display.c"; do
    [ ! -e "$file" ] || $compile -I"$tables" -c "$file" -o "$work/$(basename "$file" .c).o"
done
cd "$objects"
set -- {}
$compile -nostdlib -Wl,--gc-sections -o "$work/servo.elf" "$work"/*.o "$@" port/haptable_memory.o -lgcc
arm-none-eabi-objcopy -O binary "$work/servo.elf" "$work/servo.bin"
arm-none-eabi-size "$work/servo.elf" | awk 'NR == 2 {{ print $1, $2, $3 }}'
arm-none-eabi-nm --defined-only "$work/servo.elf")";

}  // namespace

LinkedServo link_servo(const fs::path& tables, const fs::path& objects, const std::string& offered) {
    if (!fs::exists(objects / "options")) throw Error(objects.string() + " holds no servo: make images");
    // Beside the tables; the linker gets it by a path from elsewhere.
    const StagedPath work(fs::absolute(tables / "linked"), StagedKind::folder);
    write_file(work.path() / "main.c", kMain);
    const ShellResult ran =
        run_shell(fmt::format(kLink, shell_quoted(tables), shell_quoted(work.path()), shell_quoted(objects), offered));
    if (ran.status != 0) throw Error("cannot link the servo with the tables of " + tables.string());
    LinkedServo linked;
    std::istringstream out(ran.out);
    std::size_t constants = 0, data = 0, zeros = 0;
    out >> constants >> data >> zeros;
    linked.flash = constants + data;
    linked.ram = data + zeros;
    for (std::string address, kind, name; out >> address >> kind >> name;)
        if (name.starts_with("haptable_")) linked.symbols.insert(name);
    linked.image = read_file(work.path() / "servo.bin");
    return linked;
}

}  // namespace haptable
