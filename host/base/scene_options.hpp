// SPDX-License-Identifier: GPL-2.0-or-later
// What a scene chose, by the names of its keys, every default written out: options.json of a folder of tables.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "host/base/modes.hpp"

namespace haptable {

/// Values in SI units by "section.key", or "key" of the scene itself. What is off, is not asked for or has no default
/// is not there: has() tells. Throws nlohmann::json::exception where a value is missing or of another type.
class SceneOptions {
public:
    SceneOptions();
    explicit SceneOptions(nlohmann::ordered_json values);

    bool has(std::string_view key) const;
    double number(std::string_view key) const;
    /// The same; `without` where it is not there.
    double number_or(std::string_view key, double without) const { return has(key) ? number(key) : without; }
    /// The same of what a servo takes by its size: a flag is 0 or 1, and what is off or not there 0.
    double amount(std::string_view key) const;
    std::int64_t integer(std::string_view key) const;
    bool flag(std::string_view key) const;  ///< false where it is not there
    bool is_text(std::string_view key) const;
    std::string text(std::string_view key) const;
    std::vector<double> numbers(std::string_view key) const;
    template <typename Choice>
    Choice choice(std::string_view key) const {
        const std::optional<Choice> chosen = choice_of<Choice>(text(key));
        if (!chosen) refuse(key);
        return *chosen;
    }

    const nlohmann::ordered_json& values() const { return *values_; }
    const nlohmann::ordered_json& at(std::string_view key) const;
    void set(std::string_view key, nlohmann::ordered_json value);

private:
    /// Throws Error: a word that this version does not know.
    [[noreturn]] void refuse(std::string_view key) const;

    std::shared_ptr<const nlohmann::ordered_json> values_;
};

}  // namespace haptable
