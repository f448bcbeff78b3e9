// SPDX-License-Identifier: GPL-2.0-or-later
// One object under the bench: its tables, its servo, and fingers that touch it.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "codegen/model.hpp"
#include "codegen/precision.hpp"
#include "firmware/haptable_model.h"
#include "host/tables/tables.hpp"

namespace haptable {

using FingerPath = std::vector<std::array<float, 3>>;  ///< [ticks] positions, m

/// A scene that precompute has made, with its servo in memory.
class Subject {
public:
    explicit Subject(const std::filesystem::path& folder) : Subject(folder, read_tables(folder)) {}
    /// The folder's tables, with other options.
    Subject(const std::filesystem::path& folder, Tables tables);
    Subject(const Subject&) = delete;
    Subject& operator=(const Subject&) = delete;

    const std::filesystem::path& folder() const { return folder_; }
    const Tables& tables() const { return tables_; }
    const haptable_model& model() const { return model_; }
    std::size_t table_bytes() const;  ///< of the servo, in flash
    std::vector<PrecisionError> precisions() const { return compare_precisions(tables_, servo_); }

    /// A closed circle over the upper side, `ticks` positions `depth_m` under the surface (above it where negative).
    /// A finger that begins above it and then follows it, over and over, stays in contact.
    FingerPath circle(double depth_m, std::size_t ticks) const;
    /// The servo after a finger came from above on to a path's first position.
    haptable_servo touched(const FingerPath& path) const;

private:
    double height(double x, double y) const;  ///< of the uppermost patch over (x, y), m

    std::filesystem::path folder_;
    Tables tables_;
    ServoModel servo_;
    haptable_model model_;
};

}  // namespace haptable
