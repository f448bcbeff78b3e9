// SPDX-License-Identifier: GPL-2.0-or-later
// firmware/haptable.h: its example runs as it stands, and it is all that a board's program calls.
#include <gtest/gtest.h>

#include <regex>
#include <set>

#include "codegen/codegen.hpp"
#include "host/base/file.hpp"
#include "tests/process.hpp"
#include "tests/shapes.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

/// The lines of the header's first comment that are indented as code is.
std::string example(const std::string& header) {
    const std::string comment = header.substr(0, header.find("*/"));
    std::string program;
    for (std::size_t at = 0; (at = comment.find("\n *", at)) != std::string::npos; ++at) {
        const std::string line = comment.substr(at + 3, comment.find('\n', at + 1) - at - 3);
        if (line.empty())
            program += "\n";
        else if (line.starts_with("     "))
            program += line.substr(5) + "\n";
    }
    return program;
}

/// What the reader has to bring: 200 ticks down into the top of the box; the last force is printed.
constexpr const char* kDevice =
    "#include <stdint.h>\n#include <stdio.h>\n"
    "static uint32_t tick;\nstatic float last_n;\n"
    "int device_read(int finger, float x[3]) {\n"
    "    x[0] = 0.0131f; x[1] = 0.0172f; x[2] = 0.031f - 1e-5f * (float)tick;\n    return finger == 0;\n}\n"
    "void device_write(int finger, const float f[3]) { (void)finger; last_n = f[2]; }\n"
    "int device_wait(uint32_t* now_us) {\n"
    "    *now_us = 1000u * ++tick;\n"
    "    if (tick == 200) printf(\"%.9g\\n\", (double)last_n);\n    return tick < 200;\n}\n";

TEST(Header, ItsExampleRunsAsItStands) {
    const TestModel box(box_shape(4, Eigen::Vector3d(0.03, 0.03, 0.03)), 0.001);
    const TemporaryFolder folder;
    const ModelText text = model_text(box.tables(), box.servo());
    write_file(folder.path() / "model.h", text.header);
    write_file(folder.path() / "model.c", text.source);
    write_file(folder.path() / "main.c", example(read_file("firmware/haptable.h")));
    write_file(folder.path() / "device.c", kDevice);
    const std::string path = folder.path().string();
    const Outcome compiled =
        run("gcc -std=c99 -O1 -pedantic -Wall -Wextra -Wno-maybe-uninitialized -Werror -ffp-contract=off "
            "-Ifirmware -I" +
            path + " " + path + "/*.c firmware/*.c -o " + path + "/program");
    ASSERT_EQ(compiled.status, 0) << compiled.err;
    const Outcome ran = run(path + "/program");
    ASSERT_EQ(ran.status, 0) << ran.err;
    EXPECT_GT(std::stof(ran.out), 0.01F) << "it presses back";
}

TEST(Header, IsAllThatABoardCalls) {
    const std::string header = read_file("firmware/haptable.h"), code = header.substr(header.find("*/"));
    const auto names = [&](const char* pattern) {
        std::set<std::string> found;
        const std::regex wanted(pattern);
        for (std::sregex_iterator at(code.begin(), code.end(), wanted), end; at != end; ++at) found.insert((*at)[1]);
        return found;
    };
    const std::set<std::string> functions = names("\\n(?:static inline )?[a-z][a-z0-9_ *]*[ *](haptable_[a-z_]+)\\(");
    const std::set<std::string> structs = names("struct (haptable_[a-z_]+)");
    EXPECT_TRUE(functions.contains("haptable_step") && functions.contains("haptable_line")) << functions.size();
    EXPECT_LE(functions.size(), 12U);
    EXPECT_LE(structs.size(), 10U);
    // The packages' and README's programs call nothing else.
    for (const char* file : {"firmware/README.md", "packaging/boards/arduino/examples/Touch/Touch.ino",
                             "packaging/boards/examples/stm32f4.c", "packaging/boards/examples/rp2350.c"}) {
        const std::string program = read_file(file);
        const std::regex call("\\b(haptable_[a-z_]+)\\(");
        for (std::sregex_iterator at(program.begin(), program.end(), call), end; at != end; ++at)
            EXPECT_TRUE(functions.contains((*at)[1].str())) << file << " calls " << (*at)[1];
    }
}

}  // namespace
}  // namespace haptable::test
