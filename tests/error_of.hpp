// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "host/base/error.hpp"

namespace haptable::test {

/// The message of the Error that `act` throws; "no error" where it throws none.
template <typename Act>
std::string error_of(Act act) {
    try {
        act();
    } catch (const Error& error) {
        return error.what();
    }
    return "no error";
}

/// A text with another part.
inline std::string replaced(std::string text, const std::string& part, const std::string& by) {
    return text.replace(text.find(part), part.size(), by);
}

/// Whether a text has this part; what it says where it has not.
inline testing::AssertionResult says(const std::string& text, const std::string& part) {
    if (text.find(part) != std::string::npos) return testing::AssertionSuccess();
    return testing::AssertionFailure() << "\"" << text << "\" does not say \"" << part << "\"";
}

/// Whether `act` throws an Error whose message has this part: EXPECT_TRUE(fails_with([&] { read(file); }, "no
/// tables")).
template <typename Act>
testing::AssertionResult fails_with(Act act, const std::string& part) {
    return says(error_of(act), part);
}

}  // namespace haptable::test
