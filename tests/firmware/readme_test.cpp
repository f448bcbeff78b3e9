// SPDX-License-Identifier: GPL-2.0-or-later
// firmware/README.md, done as it says: its program and its commands in an empty folder, and nothing else.
#include <gtest/gtest.h>

#include "host/base/file.hpp"
#include "tests/process.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

/// The first block of that language.
std::string block(const std::string& text, const std::string& language) {
    const std::string begin = "```" + language + "\n";
    const std::size_t from = text.find(begin) + begin.size();
    return text.substr(from, text.find("```", from) - from);
}

// What the reader has to bring.
constexpr const char* kDevice =
    "#include <stdint.h>\n"
    "int device_read(float x[3]) { x[0] = x[1] = x[2] = 0.0f; return 1; }\n"
    "volatile float motor;\n"
    "void device_write(const float f[3]) { motor = f[0]; }\n"
    "uint32_t clock_us(void) { return 0; }\n"
    "void timer_interrupt(void);\n"
    "void timer_start_1khz(void) { timer_interrupt(); }\n"
    "void timer_clear(void) {}\n";

TEST(FirmwareReadme, ItsProgramCompilesAndLinksWithoutALibrary) {
    if (run("command -v arm-none-eabi-gcc").status != 0) GTEST_SKIP() << "arm-none-eabi-gcc is not installed";
    const auto tables = std::filesystem::absolute(build_folder()) / "cube";
    if (!std::filesystem::exists(tables / "model.c")) GTEST_SKIP() << tables << " is not made: make scene";
    const std::string text = read_file("firmware/README.md");
    const TemporaryFolder folder;
    const auto app = folder.path() / "app";
    std::filesystem::create_directories(app);
    write_file(app / "main.c", block(text, "c"));
    write_file(app / "device.c", kDevice);
    // The project's path: the folder of this source, with this build's tables.
    std::filesystem::create_directories(folder.path() / "project/build");
    std::filesystem::create_symlink(std::filesystem::absolute("firmware"), folder.path() / "project/firmware");
    std::filesystem::create_symlink(tables, folder.path() / "project/build/cube");
    const Outcome compiled =
        run("HAPTABLE='" + (folder.path() / "project").string() + "'\nset -e\n" + block(text, "sh"), app);
    ASSERT_EQ(compiled.status, 0) << compiled.err;
    EXPECT_EQ(compiled.err, "");
    const Outcome linked =
        run("arm-none-eabi-gcc -mthumb -mcpu=cortex-m7 -mfpu=fpv5-sp-d16 -mfloat-abi=hard -nostdlib -Wl,--gc-sections "
            "-Wl,-e,main ./*.o -o app.elf && arm-none-eabi-size app.elf",
            app);
    ASSERT_EQ(linked.status, 0) << linked.err;
    const std::size_t bytes = std::stoul(linked.out.substr(linked.out.find('\n') + 1));
    EXPECT_GT(bytes, 6752U + 4000U) << "the tables and the servo are in it";
    EXPECT_LT(bytes, 6752U + 21100U) << "nothing that the cube does not name is: 3,700 bytes and more";
}

}  // namespace
}  // namespace haptable::test
