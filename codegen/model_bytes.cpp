// SPDX-License-Identifier: GPL-2.0-or-later
#include "codegen/model_bytes.hpp"

#include <algorithm>
#include <cstdint>
#include <initializer_list>

#include "codegen/bytes.hpp"
#include "host/base/error.hpp"

namespace haptable {

namespace {

template <typename Function>
void add_function(Function* function, std::initializer_list<Function*> choices, Bytes& bytes) {
    const auto* at = std::find(choices.begin(), choices.end(), function);
    if (function != nullptr && at == choices.end()) throw Error("a model names a function that is not the servo's");
    bytes.add(function == nullptr ? 0U : static_cast<std::uint32_t>(at - choices.begin()) + 1U);
}

// What the lists' numbers of rows speak of. NOLINTBEGIN(bugprone-macro-parentheses): names that are declared
#define HAPTABLE_NAME_VALUE(type, name) [[maybe_unused]] const auto& name = from.name;
#define HAPTABLE_NAME_FUNCTION(type, name, choices) [[maybe_unused]] const auto name = from.name;
#define HAPTABLE_NAME_PART(type, name) [[maybe_unused]] const type* name = from.name;
// NOLINTEND(bugprone-macro-parentheses)
#define HAPTABLE_PASS(...)

#define HAPTABLE_CHOICE(function) function,
#define HAPTABLE_ADD_FUNCTION(type, name, choices) add_function<type>(from.name, {choices(HAPTABLE_CHOICE)}, bytes);
#define HAPTABLE_ADD_PART(type, name)                            \
    bytes.add(static_cast<std::uint32_t>(from.name != nullptr)); \
    if (from.name != nullptr) add(*from.name, vertex_count, patch_count, bytes);

void add(const haptable_compliance& from, std::uint16_t vertex_count, std::uint16_t patch_count, Bytes& bytes) {
    HAPTABLE_COMPLIANCE_FIELDS(HAPTABLE_NAME_VALUE, HAPTABLE_PASS)
    HAPTABLE_COMPLIANCE_FIELDS(HAPTABLE_ADD_VALUE, HAPTABLE_ADD_TABLE)
}

}  // namespace

std::string model_bytes(const haptable_model& from) {
    HAPTABLE_MODEL_FIELDS(HAPTABLE_NAME_VALUE, HAPTABLE_PASS, HAPTABLE_NAME_FUNCTION, HAPTABLE_NAME_PART)
    Bytes bytes;
    HAPTABLE_MODEL_FIELDS(HAPTABLE_ADD_VALUE, HAPTABLE_ADD_TABLE, HAPTABLE_ADD_FUNCTION, HAPTABLE_ADD_PART)
    return bytes.take();
}

}  // namespace haptable
