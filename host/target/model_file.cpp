// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/target/model_file.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <iterator>

#include "host/base/error.hpp"

namespace haptable {

namespace {

static_assert(std::endian::native == std::endian::little);

/// The number of the function among the choices, which stand in the order of measure.c.
template <typename Function, std::size_t n>
std::uint32_t number_of(Function* function, Function* const (&choices)[n]) {
    const auto* at = std::find(std::begin(choices), std::end(choices), function);
    if (at == std::end(choices)) throw Error("a model for the measure image names a function that it does not know");
    return static_cast<std::uint32_t>(at - std::begin(choices));
}

class Words {
public:
    void add(std::uint32_t word) { text_.append(reinterpret_cast<const char*>(&word), sizeof word); }
    void add(float number) { add(std::bit_cast<std::uint32_t>(number)); }
    void add_table(const void* table, std::size_t bytes) {
        text_.append(static_cast<const char*>(table), bytes);
        text_.append((4 - bytes % 4) % 4, '\0');
    }
    std::string take() { return std::move(text_); }

private:
    std::string text_;
};

std::uint32_t unpack_of(const haptable_model& model) {
    haptable_unpack_fn* const choices[] = {nullptr, haptable_unpack_float16, haptable_unpack_int16};
    return number_of(model.unpack, choices);
}

void add_functions(const haptable_model& model, Words& words) {
    haptable_god_object_fn* const gods[] = {haptable_god_object_nearest, haptable_god_object_least_energy};
    haptable_force_fn* const forces[] = {haptable_force_interpolated, haptable_force_consistent,
                                         haptable_force_pressure_mask, haptable_force_of_least_energy};
    haptable_energy_fn* const energies[] = {nullptr, haptable_energy_interpolated, haptable_energy_consistent,
                                            haptable_energy_pressure_mask};
    const bool friction = model.god_object == haptable_god_object_friction;
    words.add(number_of(friction ? model.frictionless : model.god_object, gods));
    words.add(std::uint32_t{friction});
    words.add(number_of(model.force, forces));
    words.add(number_of(model.energy, energies));
    words.add(unpack_of(model));
    words.add(std::uint32_t{model.release != nullptr});
    words.add(std::uint32_t{model.passivity != nullptr});
}

void add_numbers(const haptable_model& model, Words& words) {
    for (const float number :
         {model.max_force_n, model.rigid_stiffness_n_per_m, model.tolerance_m, model.workspace_limit_m,
          model.grid_origin_m[0], model.grid_origin_m[1], model.grid_origin_m[2], model.grid_per_m,
          model.static_friction, model.kinetic_friction, model.stiffness_limit_n_per_m, model.release_n})
        words.add(number);
}

void add_blocks(const haptable_model& model, Words& words) {
    if (model.compliance != nullptr) {
        const haptable_compliance& c = *model.compliance;
        words.add_table(c.vertex, std::size_t{24} * model.vertex_count);
        words.add_table(c.edge, std::size_t{24} * c.edge_count * (c.degree - 1U));
        words.add_table(c.patch, c.degree == 4 ? std::size_t{72} * model.patch_count : 0);
        words.add_table(c.patch_edge, std::size_t{6} * model.patch_count);
    } else if (model.unpack != nullptr) {
        words.add_table(model.packed, std::size_t{12} * model.free_count);
        words.add_table(model.packed_scale_n_per_m, unpack_of(model) == 1 ? 4 : std::size_t{4} * model.free_count);
    } else {
        words.add_table(model.stiffness_n_per_m, std::size_t{24} * model.free_count);
    }
}

}  // namespace

std::string model_file(const haptable_model& model) {
    Words words;
    add_functions(model, words);
    words.add(model.compliance != nullptr ? std::uint32_t{model.compliance->degree} : 0U);
    for (const std::uint16_t count :
         {model.vertex_count, model.free_count, model.patch_count, model.box_count, model.hinge_count})
        words.add(std::uint32_t{count});
    words.add(model.compliance != nullptr ? std::uint32_t{model.compliance->edge_count} : 0U);
    add_numbers(model, words);
    words.add_table(model.vertex_m, std::size_t{12} * model.vertex_count);
    words.add_table(model.patch, std::size_t{6} * model.patch_count);
    words.add_table(model.neighbour, std::size_t{6} * model.patch_count);
    words.add_table(model.box, std::size_t{16} * model.box_count);
    words.add_table(model.hinge, std::size_t{6} * model.hinge_count);
    add_blocks(model, words);
    return words.take();
}

}  // namespace haptable
