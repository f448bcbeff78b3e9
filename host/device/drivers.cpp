// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/device/drivers.hpp"

#include <fmt/format.h>

#include "host/base/command_line.hpp"

namespace haptable {

namespace {

struct DriverEntry {
    const char* name;
    std::unique_ptr<Driver> (*open)(const DriverOptions&);
};

constexpr DriverEntry kDrivers[] = {
#define HAPTABLE_DRIVER(name) {#name, open_##name},
#include "host/device/drivers.inc"
};

}  // namespace

std::string driver_names() {
    std::string names;
    for (const DriverEntry& one : kDrivers) names += (names.empty() ? "" : ", ") + std::string(one.name);
    return names;
}

std::unique_ptr<Driver> open_driver(const std::string& name, const DriverOptions& options) {
    for (const DriverEntry& one : kDrivers)
        if (name == one.name) return one.open(options);
    throw BadCommandLine(fmt::format("--driver: there is no {}; there are simulated, {}", name, driver_names()));
}

}  // namespace haptable
