// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/program.hpp"

#include <cstdio>
#include <new>

#include "host/base/error.hpp"
#include "host/base/interrupt.hpp"

namespace haptable {

namespace {

/// Errors are one line: what follows a line break in a library's message is joined to it.
std::string one_line(std::string text) {
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
    for (char& c : text)
        if (c == '\n' || c == '\r') c = ' ';
    return text;
}

int fail(const std::string& program, const std::string& what, int status) {
    std::fprintf(stderr, "%s: %s\n", program.c_str(), one_line(what).c_str());
    return status;
}

}  // namespace

int run_program(CommandLine& command_line, int argc, char** argv, const std::function<void()>& work) {
    const std::string& program = command_line.program();
    try {
        if (!command_line.parse(argc, argv)) return 0;
        work();
        if (std::fflush(stdout) != 0) throw Error("standard output cannot be written: is the disk full?");
        return 0;
    } catch (const BadCommandLine& error) {
        return fail(program, error.what(), 2);
    } catch (const Interrupted&) {
        return fail(program, "interrupted: nothing half-written was left", 130);
    } catch (const std::bad_alloc&) {
        return fail(program, "out of memory: use a coarser mesh or a smaller touch region", 1);
    } catch (const std::exception& error) {
        return fail(program, error.what(), 1);
    }
}

}  // namespace haptable
