// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-contact: ticks of every contact mode beside those of finger proxies, for docs/CONTACT.md.
#include <filesystem>

#include "host/base/program.hpp"
#include "host/bench/contact/beside.hpp"
#include "host/numbers/numbers.hpp"

int main(int argc, char** argv) {
    using namespace haptable;
    CommandLine app("Times the contact modes' ticks beside finger proxies.", "haptable-contact");
    std::filesystem::path build = "build/contact", out;
    int rounds = 30;
    app.option("--build", build, "folder for tables").show_default();
    app.option("-o", out, "write the numbers to this JSON file");
    app.option("--rounds", rounds, "every tick is as fast as it was in any of so many").show_default();
    return run_program(app, argc, argv, [&] {
        std::filesystem::create_directories(build);
        Numbers numbers("make bench");
        const auto [finger, shell] = beside_proxies(build, rounds);
        numbers.add("modes-beside", finger);
        numbers.add("modes-beside-shells", shell);
        print_topics(numbers);
        if (!out.empty()) numbers.write(out);
    });
}
