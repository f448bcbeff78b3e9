// SPDX-License-Identifier: GPL-2.0-or-later
// Many strokes, and what became of them: over one body in one mode, and over all bodies in all modes, which takes long:
// what is counted is kept, and a campaign that was cut short goes on.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>

#include "host/base/workers.hpp"
#include "host/strokes/meshes.hpp"
#include "host/strokes/stroked_body.hpp"

namespace haptable {

/// A stroke that broke something.
struct Broken {
    std::uint64_t number;
    Verdict verdict;  ///< of one that was kept in a file only `tick`
};

struct Tally {
    std::size_t strokes = 0, ticks = 0, contact_ticks = 0;
    std::size_t both_ticks = 0;                 ///< two fingers in contact, or more
    std::size_t limits = 0;                     ///< of walks, slides and boxes
    std::array<std::size_t, kFaults> faulty{};  ///< strokes with each fault
    double most_area = 0.0;                     ///< by which area coordinates miss a sum of 1
    // By design (docs/CONTACT.md):
    std::size_t clamped = 0;                  ///< strokes that met max_force: their energy is judged until then
    std::size_t behind = 0, long_behind = 0;  ///< strokes in contact out of the god-object's sight; of over 20 ticks
    std::size_t passed = 0;                   ///< motions of a tick through the body that were not felt
    double cpu_s = 0.0;                       ///< that the strokes and their judge took
    std::vector<Broken> broken;               ///< ascending

    void add(std::uint64_t number, const Stroke& stroke, const Verdict& verdict);
    void add(const Tally& other);
};

/// Strokes number 0 .. count - 1 of that seed. The result does not depend on the number of threads, but for cpu_s.
/// on_done: strokes done so far, called from one thread at a time.
Tally run_strokes(const Touched& touched, std::uint64_t seed, std::size_t count, Workers& workers,
                  const std::function<void(std::size_t done)>& on_done);

struct CampaignOptions {
    std::vector<std::filesystem::path> places;  ///< scenes, meshes, folders of them
    std::vector<std::string> meshes, modes;     ///< only those with one of these in their names; all where empty
    std::size_t strokes = 1'000'000;            ///< in all
    std::uint64_t seed = 1;
    std::size_t most_nodes = 150'000;      ///< of a mesh
    std::size_t most_mask_nodes = 50'000;  ///< of a mesh that is touched by masks, whose tables grow most
    /// Bytes: larger ones are touched by two fingers as far as what couples any two places needs no more.
    std::uintmax_t most_coupling = 100'000'000;
    std::filesystem::path folder = "build/strokes";
    int threads = 0;  ///< 0: all processors
    bool quiet = false;
};

/// Strokes every body that passes the audit in every mode, as often each. After a body and mode its counts are kept in
/// `folder`/counts, by program, mesh, mode, seed and number of strokes; another run takes them from there. Some strokes
/// of each fault are shrunk, written, and told on standard output. Throws Error where there is nothing to stroke.
/// Returns every tally of every body, their sum, what each mode is, and what was left out: lab/strokes.py makes the
/// pages' tables of it.
nlohmann::ordered_json run_campaign(const CampaignOptions& options);

}  // namespace haptable
