// SPDX-License-Identifier: GPL-2.0-or-later
// A scene as a library for other people's projects: one list of files, each kind taken in as its own tools would.
#include "codegen/export.hpp"

#include <gtest/gtest.h>

#include <map>

#include "host/base/file.hpp"
#include "tests/process.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/wheels.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kKinds[] = {"arduino", "cmake", "cmsis-pack", "esp-idf", "platformio", "zephyr"};
constexpr const char* kStm32 = "-mthumb -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mfloat-abi=hard";
constexpr const char* kRp2350 = "-mthumb -mcpu=cortex-m33 -mfpu=fpv5-sp-d16 -mfloat-abi=hard";
constexpr std::size_t kTableBytes = 6752, kMostCodeBytes = 21100;  // of the cube, as in firmware/README.md's test
constexpr double kMoreByO3 = 1.15;                                 // where functions are inlined whatever they weigh

/// What the reader of an example has to bring.
constexpr const char* kDevice =
    "int device_read(float x[3]) { x[0] = x[1] = x[2] = 0.0f; return 1; }\n"
    "volatile float motor;\n"
    "void device_write(const float f[3]) { motor = f[0]; }\n";

class Export : public testing::Test {
protected:
    static void SetUpTestSuite() {
        folder_ = std::make_unique<TemporaryFolder>();
        if (!fs::exists(build_folder() / "cube/model.c")) return;
        fs::copy(build_folder() / "cube", root() / "tables");
        for (const std::string kind : kKinds) made_[kind] = codegen(kind, kind);
    }
    static void TearDownTestSuite() { folder_.reset(); }
    void SetUp() override {
        if (made_.empty()) GTEST_SKIP() << "build/cube is not made: make scene";
        for (const auto& [kind, outcome] : made_) ASSERT_EQ(outcome.status, 0) << kind << ": " << outcome.err;
    }

    static fs::path root() { return folder_->path(); }
    static Outcome codegen(const std::string& kind, const std::string& out) {
        return run(program("haptable-codegen").string() + " tables --export " + kind + " -o " + out, root());
    }
    static bool has_cross_compiler() { return run("command -v arm-none-eabi-gcc").status == 0; }

    /// Flash of a linked program, as the cross tools count it.
    static void expect_size(const std::string& elf, double more = 1.0) {
        const Outcome size = run("arm-none-eabi-size " + elf, root());
        ASSERT_EQ(size.status, 0) << size.err;
        const std::size_t bytes = std::stoul(size.out.substr(size.out.find('\n') + 1));
        EXPECT_GT(bytes, kTableBytes + 4000U) << elf << ": the tables and the servo are in it";
        EXPECT_LT(double(bytes), double(kTableBytes) + more * double(kMostCodeBytes)) << elf;
        const Outcome others =
            run("arm-none-eabi-nm " + elf + " | grep -E 'haptable_(part|pair|modes|moving|rows|relax)'", root());
        EXPECT_EQ(others.out, "") << elf << ": nothing that the cube does not name is in it";
    }

    static inline std::unique_ptr<TemporaryFolder> folder_;
    static inline std::map<std::string, Outcome> made_;
};

TEST_F(Export, HasTheSameFilesForEveryKind) {
    const ServoSources expected = servo_sources("firmware", root() / "tables");
    ASSERT_GT(expected.sources.size(), 20U);
    for (const std::string kind : kKinds) {
        std::size_t files = 0;
        for (const auto& list : {expected.sources, expected.headers})
            for (const fs::path& file : list) {
                EXPECT_EQ(read_file(root() / kind / "src" / file.filename()), read_file(file)) << kind;
                ++files;
            }
        const auto written = fs::directory_iterator(root() / kind / "src");
        EXPECT_EQ(static_cast<std::size_t>(std::distance(fs::begin(written), fs::end(written))), files) << kind;
        for (const auto& entry : fs::recursive_directory_iterator(root() / kind))
            if (entry.is_regular_file() && entry.path().parent_path().filename() != "src") {
                const std::string text = read_file(entry.path());
                for (const char* mark :
                     {"@name@", "@NAME@", "@scene@", "@version@", "@sources@", "@tables_hash@", "@component_files@"})
                    EXPECT_EQ(text.find(mark), std::string::npos) << entry.path() << " " << mark;
            }
    }
}

TEST_F(Export, RefusesKindsAndFoldersThatItCannotTake) {
    const Outcome kind = codegen("avr", "none");
    EXPECT_EQ(kind.status, 1);
    EXPECT_NE(kind.err.find("\"avr\" is none of arduino, cmake, cmsis-pack, esp-idf, platformio, zephyr"),
              std::string::npos)
        << kind.err;
    EXPECT_FALSE(fs::exists(root() / "none"));
    const Outcome again = codegen("cmake", "cmake");
    EXPECT_EQ(again.status, 1);
    EXPECT_NE(again.err.find("cmake: is there already"), std::string::npos) << again.err;
    EXPECT_EQ(run(program("haptable-codegen").string() + " tables --export cmake", root()).status, 2);
}

TEST_F(Export, ExamplesCompileAndLinkForTheirCores) {
    if (!has_cross_compiler()) GTEST_SKIP() << "arm-none-eabi-gcc is not installed";
    write_file(root() / "device.c", kDevice);
    const std::string memory = fs::absolute("firmware/port/haptable_memory.c").string();
    for (const auto& [example, core] : std::map<std::string, std::string>{{"stm32f4", kStm32}, {"rp2350", kRp2350}}) {
        const Outcome built =
            run("arm-none-eabi-gcc " + core + " -std=c99 -ffreestanding -O2 -ffp-contract=off -fno-math-errno " +
                    "-fno-tree-loop-distribute-patterns -ffunction-sections -fdata-sections -Wall -Wextra -Werror "
                    "-Iplatformio/src " +
                    "platformio/examples/" + example + ".c platformio/src/*.c device.c " + memory +
                    " -nostdlib -Wl,--gc-sections -Wl,-e,main -lgcc -o " + example + ".elf",
                root());
        ASSERT_EQ(built.status, 0) << example << ": " << built.err;
        expect_size(example + ".elf");
    }
}

TEST_F(Export, ArduinosSketchCompiles) {
    if (!has_cross_compiler()) GTEST_SKIP() << "arm-none-eabi-gcc is not installed";
    write_file(root() / "main.cpp",
               "#include <stdint.h>\nuint32_t micros() { return 0; }\n#include \"arduino/examples/Touch/Touch.ino\"\n"
               "int main() { setup(); for (;;) loop(); }\n");
    const std::string flags =
        std::string(kStm32) + " -O2 -ffunction-sections -fdata-sections -Wall -Wextra -Werror -Iarduino/src ";
    const std::string memory = fs::absolute("firmware/port/haptable_memory.c").string();
    const Outcome built =
        run("mkdir -p ino && cd ino && arm-none-eabi-gcc " + flags +
                "-I../arduino/src -ffreestanding -fno-tree-loop-distribute-patterns -c ../arduino/src/*.c " + memory +
                " && arm-none-eabi-g++ -I.. -I../arduino/src -ffreestanding -fno-exceptions -fno-rtti "
                "-fno-threadsafe-statics " +
                flags + "-c ../main.cpp && arm-none-eabi-g++ " + flags +
                "*.o -nostdlib -Wl,--gc-sections -Wl,-e,main -lgcc -o ../ino.elf",
            root());
    ASSERT_EQ(built.status, 0) << built.err;
    expect_size("ino.elf");
}

TEST_F(Export, CMakeTakesItAsASubdirectory) {
    if (!has_cross_compiler()) GTEST_SKIP() << "arm-none-eabi-gcc is not installed";
    fs::create_directories(root() / "app");
    write_file(root() / "app/device.c", kDevice);
    fs::copy_file("firmware/port/haptable_memory.c", root() / "app/haptable_memory.c",
                  fs::copy_options::overwrite_existing);
    write_file(root() / "app/CMakeLists.txt",
               "cmake_minimum_required(VERSION 3.16)\nproject(app C)\nadd_subdirectory(../cmake body)\n"
               "add_executable(app.elf ../cmake/examples/rp2350.c device.c haptable_memory.c)\n"
               "target_compile_options(app.elf PRIVATE -fno-tree-loop-distribute-patterns)\n"
               "target_link_libraries(app.elf PRIVATE haptable::cube gcc)\n"
               "target_link_options(app.elf PRIVATE -nostdlib -Wl,--gc-sections -Wl,-e,main)\n");
    const Outcome built =
        run(std::string("cmake -S app -B out -DCMAKE_SYSTEM_NAME=Generic -DCMAKE_C_COMPILER=arm-none-eabi-gcc "
                        "-DCMAKE_TRY_COMPILE_TARGET_TYPE=STATIC_LIBRARY -DCMAKE_BUILD_TYPE=Release "
                        "'-DCMAKE_C_FLAGS=") +
                kRp2350 + " -ffreestanding' >/dev/null && cmake --build out >/dev/null",
            root());
    ASSERT_EQ(built.status, 0) << built.err;
    expect_size("out/app.elf", kMoreByO3);
}

/// Zephyr's and ESP-IDF's own functions are not here: in their place ones that look at every file.
TEST_F(Export, ZephyrsAndEspIdfsListsNameEveryFile) {
    write_file(
        root() / "lists.cmake",
        "function(look)\nforeach(file ${ARGN})\nif(NOT EXISTS ${file})\nmessage(FATAL_ERROR \"no ${file}\")\nendif()\n"
        "math(EXPR n \"${n} + 1\")\nendforeach()\nmessage(STATUS \"${n} files\")\nendfunction()\n"
        "function(zephyr_library_named)\nendfunction()\nfunction(zephyr_library_compile_options)\nendfunction()\n"
        "function(zephyr_include_directories)\nlook(${ARGV})\nendfunction()\n"
        "function(zephyr_library_sources)\nlook(${ARGV})\nendfunction()\n"
        "function(target_compile_options)\nendfunction()\n"
        "function(idf_component_register)\ncmake_parse_arguments(A \"\" \"\" \"SRCS;INCLUDE_DIRS\" ${ARGN})\n"
        "list(TRANSFORM A_SRCS PREPEND ${CMAKE_CURRENT_LIST_DIR}/)\nlook(${A_SRCS})\nendfunction()\n"
        "set(CONFIG_HAPTABLE_CUBE y)\ninclude(zephyr/zephyr/CMakeLists.txt)\ninclude(esp-idf/CMakeLists.txt)\n");
    const Outcome looked = run("cmake -P lists.cmake", root());
    ASSERT_EQ(looked.status, 0) << looked.err;
    const std::string files =
        "-- " + std::to_string(servo_sources("firmware", root() / "tables").sources.size()) + " files\n";
    EXPECT_EQ(looked.out, files + "-- 1 files\n" + files);
}

/// What packchk looks at first: it can be read, and every file of it is there. Its own schema is not here.
TEST_F(Export, ThePackNamesItsFiles) {
    const Outcome read =
        run("python3 -c 'import pathlib, xml.etree.ElementTree as tree\n"
            "root = pathlib.Path(\"cmsis-pack\")\n"
            "pack = tree.parse(root / \"haptable.haptable_cube.pdsc\").getroot()\n"
            "files = pack.findall(\"components/component/files/file\")\n"
            "assert all((root / f.get(\"name\")).exists() for f in files)\n"
            "print(sum(f.get(\"category\") == \"sourceC\" for f in files))'",
            root());
    ASSERT_EQ(read.status, 0) << read.err;
    EXPECT_EQ(read.out, std::to_string(servo_sources("firmware", root() / "tables").sources.size()) + "\n");
}

/// And the firmware alone, whose manifests are checked in.
TEST_F(Export, TheirOwnToolsTakeThem) {
    if (!has_wheels()) GTEST_SKIP() << kNoWheels;
    const Outcome said =
        run(pip_of_wheels() + "sh packaging/validate.sh " + root().string() + " " + (root() / "venv").string());
    EXPECT_EQ(said.status, 0) << said.out << said.err;
}

}  // namespace
}  // namespace haptable::test
