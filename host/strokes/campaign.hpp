// SPDX-License-Identifier: GPL-2.0-or-later
// Many strokes: over one body in one mode, and over all bodies in all modes, which takes long: what is counted is kept,
// and a campaign that was cut short goes on.
#pragma once

#include <functional>

#include "host/base/workers.hpp"
#include "host/strokes/meshes.hpp"
#include "host/strokes/stroked_body.hpp"
#include "host/strokes/tally.hpp"

namespace haptable {

/// Strokes number 0 .. count - 1 of that seed. The result does not depend on the number of threads, but for cpu_s.
/// on_done: strokes done so far, called from one thread at a time.
Tally run_strokes(const Touched& touched, const StrokeMaker& maker, std::uint64_t seed, std::size_t count,
                  Workers& workers, const std::function<void(std::size_t done)>& on_done);

struct CampaignOptions {
    std::vector<std::filesystem::path> places;  ///< scenes, meshes, folders of them
    std::vector<std::string> meshes, modes;     ///< only those with one of these in their names; all where empty
    std::size_t strokes = 1'000'000;            ///< in all
    std::uint64_t seed = 1;
    std::size_t most_nodes = 150'000;      ///< of a mesh
    std::size_t most_mask_nodes = 50'000;  ///< of a mesh that is touched by masks, whose tables grow most
    /// Bytes: larger ones are touched by two fingers as far as what couples any two places needs no more.
    std::uintmax_t most_coupling = 100'000'000;
    std::size_t examples = 3;  ///< of each fault, body and mode: shrunk and written
    std::filesystem::path folder = "build/strokes";
    int threads = 0;     ///< 0: all processors
    bool again = false;  ///< what earlier runs counted is not taken
};

/// One body: a tally for each of the modes; without strokes where it was not touched so.
struct StrokedMeshResult {
    StrokedMesh mesh;
    std::vector<Tally> tally;   ///< [m]
    double tables_cpu_s = 0.0;  ///< that its tables took when they were made

    Tally total() const { return sum_of(tally); }
};

struct CampaignResult {
    std::uint64_t seed = 0;
    std::vector<TouchMode> modes;  ///< [m]
    std::vector<StrokedMeshResult> results;
    std::vector<LeftOut> left_out;
    std::size_t taken_over = 0;  ///< strokes that an earlier run had counted

    Tally total() const;
};

/// Every tally of every body, their sum, and what each mode is: lab/strokes.py makes the pages' tables of it.
nlohmann::ordered_json to_json(const CampaignResult& result);

/// Strokes every body that passes the audit in every mode, as often each. After a body and mode its counts are kept in
/// `folder`/counts, by program, mesh, mode, seed and number of strokes; another run takes them from there. `told`: a
/// line for each stroke that was written. Throws Error where there is nothing to stroke.
CampaignResult run_campaign(const CampaignOptions& options, Progress& progress,
                            const std::function<void(const std::string& line)>& told);

}  // namespace haptable
