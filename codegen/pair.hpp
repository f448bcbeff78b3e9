// SPDX-License-Identifier: GPL-2.0-or-later
// What couples two fingers, as the servo holds it: beside its model, in the same two files.
#pragma once

#include <string>

#include "codegen/model.hpp"
#include "codegen/template.hpp"
#include "firmware/haptable_pair.h"
#include "host/tables/pair.hpp"

namespace haptable {

/// The tables of struct haptable_pair_model, by their names there. Of the interpolated force blocks are S_k C_kl S_l.
struct ServoPair {
    std::vector<std::array<float, 9>> block;
    PairClusters clusters;  ///< places and their patches in the two below
    std::vector<std::uint16_t> place, load_place;
    std::vector<std::uint32_t> load_begin;
    std::uint16_t control_count = 0;
    std::uint16_t finger_count = 2;  ///< of a tool 1
    float meeting_m = 0.0F;

    bool is_exact() const { return clusters.scale.empty(); }
};

/// Throws Error where the tables do not fit the model, or hold a number that no float does.
ServoPair build_pair(const PairTables& pair, const Tables& tables, const ServoModel& servo);

/// Points to the model and to the pair's tables, which must outlive it.
haptable_pair_model pair_in_memory(const ServoPair& pair, const Tables& tables, const haptable_model& model);

/// What port/haptable_scene_reader.c reads behind the model's bytes: the number of the force law, then the fields in
/// the order of HAPTABLE_PAIR_FIELDS, as model_bytes has a model's.
std::string coupling_bytes(const haptable_pair_model& pair);

/// Bytes of flash, by table.
std::vector<TableBytes> flash_tables(const ServoPair& pair);

/// What model.c says of it.
void add_pair_values(const ServoPair& pair, const Tables& tables, const haptable_model& model, TemplateValues& values);

}  // namespace haptable
