// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/device/drivers.hpp"

#include <fmt/format.h>

#include <array>

#include "host/base/error.hpp"

namespace haptable {

namespace {

struct NamedDriver {
    const char* name;
    std::unique_ptr<Driver> (*open)(const DriverOptions&);
};

// A new driver: its file, a line in drivers.hpp, and one here.
constexpr std::array kDrivers{NamedDriver{"inverse3", open_inverse3}, NamedDriver{"hapi", open_hapi},
                              NamedDriver{"falcon", open_falcon}};

}  // namespace

std::unique_ptr<Driver> open_driver(const std::string& name, const DriverOptions& options) {
    std::string known = "simulated";
    for (const NamedDriver& one : kDrivers) {
        if (name == one.name) return one.open(options);
        known += std::string(", ") + one.name;
    }
    throw Error(fmt::format("--driver: there is no {}; there are {}", name, known));
}

}  // namespace haptable
