// SPDX-License-Identifier: GPL-2.0-or-later
// What a scene may choose, as enums, and the scene's words for it.
#pragma once

#include <array>
#include <optional>
#include <ostream>
#include <string_view>

namespace haptable {

/// How a tetrahedron deforms (host/fem/stiffness.hpp).
enum class Element { kLinear, kAverageNodalPressure, kQuadratic };
enum class ForceLaw {
#define HAPTABLE_FORCE_LAW(NAME, ...) k##NAME,
#include "host/base/laws.inc"
};
enum class GodObject {
#define HAPTABLE_GOD_OBJECT(NAME, ...) k##NAME,
#include "host/base/laws.inc"
};
/// How numbers of a table are stored.
enum class Storage { kFloat32, kFloat16, kInt16 };
/// Rows of the columns that are kept for the deformation.
enum class ColumnRows { kSurface, kAll, kNone };

constexpr std::array<const char*, 3> words(Element /*kind*/) {
    return {"linear", "average-nodal-pressure", "quadratic"};
}
constexpr auto words(ForceLaw /*kind*/) {
    return std::to_array({
#define HAPTABLE_FORCE_LAW(NAME, WORD, ...) WORD,
#include "host/base/laws.inc"
    });
}
/// Degree of the contact's compliance C(alpha) in the tables; 0: they hold none.
constexpr int degree_of(ForceLaw law) {
    constexpr int kDegree[] = {
#define HAPTABLE_FORCE_LAW(NAME, WORD, TITLE, FUNCTION, PACKED, DEGREE, ...) DEGREE,
#include "host/base/laws.inc"
    };
    return kDegree[static_cast<std::size_t>(law)];
}
constexpr auto words(GodObject /*kind*/) {
    return std::to_array({
#define HAPTABLE_GOD_OBJECT(NAME, WORD, ...) WORD,
#include "host/base/laws.inc"
    });
}
constexpr std::array<const char*, 3> words(Storage /*kind*/) { return {"float32", "float16", "int16"}; }
constexpr std::array<const char*, 3> words(ColumnRows /*kind*/) { return {"surface", "all", "none"}; }

/// The scene's word.
template <typename Choice>
constexpr const char* word(Choice choice) {
    return words(choice)[static_cast<std::size_t>(choice)];
}

/// The choice of that word, if there is one.
template <typename Choice>
std::optional<Choice> choice_of(std::string_view text) {
    const auto all = words(Choice{});
    for (std::size_t i = 0; i < all.size(); ++i)
        if (text == all[i]) return static_cast<Choice>(i);
    return {};
}

/// All of them, as in a loop.
template <typename Choice>
constexpr auto every() {
    std::array<Choice, words(Choice{}).size()> all{};
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<Choice>(i);
    return all;
}

/// For messages.
template <typename Choice>
requires requires(Choice choice) { words(choice); }
std::ostream& operator<<(std::ostream& out, Choice choice) { return out << word(choice); }

}  // namespace haptable
