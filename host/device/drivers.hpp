// SPDX-License-Identifier: GPL-2.0-or-later
// Drivers of real devices, by name. Never on hardware: each was tried against an emulator.
#pragma once

#include <memory>
#include <string>

#include "host/device/driver.hpp"

namespace haptable {

struct DriverOptions {
    std::string port;                          ///< of a serial line: "/dev/ttyACM0"
    std::string url = "ws://localhost:10001";  ///< of Haply's service
    int hardware = 3;                          ///< of the 2diy: 3 plastic, 2 metal
    double max_force_n = 0.0;                  ///< of the motors
    double patience_s = 5.0;                   ///< for the first reading
    double silence_s = 0.02;                   ///< a device that does not answer for so long has gone
};

#define HAPTABLE_DRIVER(name) std::unique_ptr<Driver> open_##name(const DriverOptions& options);
#include "host/device/drivers.inc"

/// "inverse3, hapi, falcon"
std::string driver_names();

/// One of these. Throws Error for another name, or where the device does not answer.
std::unique_ptr<Driver> open_driver(const std::string& name, const DriverOptions& options);

}  // namespace haptable
