// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/base/shell.hpp"

#include <gtest/gtest.h>

#include "tests/process.hpp"

namespace haptable::test {
namespace {

TEST(ShellQuoted, IsOneWordOfAShell) {
    for (const std::string name : {"$(touch pwned)", "`touch pwned`", "'; touch pwned; echo '", "\";touch pwned;\"",
                                   "a\ntouch pwned\n", "\\'; touch pwned; \\'", "a\\", "'", "''", "*", "~", "a b  c"})
        EXPECT_EQ(run("printf '%s|' " + shell_quoted(name)).out, name + "|");
    EXPECT_EQ(no_option("-x"), "./-x");
}

}  // namespace
}  // namespace haptable::test
