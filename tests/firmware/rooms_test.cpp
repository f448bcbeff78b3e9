// SPDX-License-Identifier: GPL-2.0-or-later
// scripts/rooms.sh: the firmware keeps its own rooms, and each way out of them is seen in a copy of it.
#include <gtest/gtest.h>

#include <fstream>
#include <map>

#include "tests/process.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;

/// What rooms.sh says of a copy of the firmware with more text at the end of files.
Outcome with(const std::map<std::string, std::string>& more) {
    const TemporaryFolder folder;
    fs::copy("firmware", folder.path() / "firmware");
    for (const auto& [file, text] : more) std::ofstream(folder.path() / "firmware" / file, std::ios::app) << text;
    return run("FIRMWARE='" + (folder.path() / "firmware").string() + "' sh scripts/rooms.sh");
}

void expect_fault(const Outcome& found, const std::string& words) {
    EXPECT_EQ(found.status, 1) << found.out;
    EXPECT_NE(found.err.find(words), std::string::npos) << found.err;
}

TEST(Rooms, OfTheFirmwareAreKept) {
    const Outcome found = run("sh scripts/rooms.sh");
    EXPECT_EQ(found.status, 0) << found.err;
    EXPECT_NE(found.out.find("\ncoupling "), std::string::npos) << found.out;
}

TEST(Rooms, AnIncludeGoesUp) {
    expect_fault(with({{"haptable_hinge.c", "#include \"haptable_contact.h\"\n"}}),
                 "hinge (surface) includes contact, which is above it (contact)");
}

TEST(Rooms, ACallGoesUp) {
    expect_fault(with({{"haptable_limit.c",
                        "void haptable_up(struct haptable_servo* servo);\n"
                        "void haptable_up(struct haptable_servo* servo) { haptable_servo_init(servo); }\n"}}),
                 "limit (guard) calls haptable_servo_init of servo, which is above it (step)");
}

TEST(Rooms, FilesOfARoomGoInACircle) {
    expect_fault(with({{"haptable_surface.c", "#include \"haptable_side.h\"\n"}}), "a circle of files: surface side");
}

TEST(Rooms, AHeaderWorksForAnotherRoom) {
    const std::string function =
        "#ifndef HAPTABLE_WORK\n#define HAPTABLE_WORK\n"
        "static inline int work(int a) {\n    a += a;\n    return a;\n}\n#endif\n";
    const std::string call = "int haptable_call(void);\nint haptable_call(void) { return work(1); }\n";
    expect_fault(with({{"haptable_contact.h", function}, {"haptable_servo.c", call}}),
                 "servo (step) calls work() of a header of contact: move it into a .c file");
    EXPECT_EQ(with({{"haptable_contact.h", function}, {"haptable_friction.c", call}}).status, 0) << "its own room";
    EXPECT_EQ(with({{"haptable_vector.h", function}, {"haptable_servo.c", call}}).status, 0) << "a room with a *";
}

TEST(Rooms, AFileHasNone) {
    expect_fault(with({{"haptable_new.h", "\n"}}), "haptable_new.h is in no room of rooms.txt");
}

}  // namespace
}  // namespace haptable::test
