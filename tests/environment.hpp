// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cstdlib>
#include <optional>
#include <string>

namespace haptable::test {

/// While it lives, a variable of the environment has another value.
class Environment {
public:
    Environment(const char* name, const std::string& value) : name_(name) {
        if (const char* kept = std::getenv(name)) kept_ = kept;
        setenv(name, value.c_str(), 1);
    }
    ~Environment() { kept_ ? setenv(name_, kept_->c_str(), 1) : unsetenv(name_); }
    Environment(const Environment&) = delete;
    Environment& operator=(const Environment&) = delete;

private:
    const char* name_;
    std::optional<std::string> kept_;
};

}  // namespace haptable::test
