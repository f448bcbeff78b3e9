// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

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

}  // namespace haptable::test
