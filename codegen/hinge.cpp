// SPDX-License-Identifier: GPL-2.0-or-later
// Vertices whose patches fall into more than one ring, or are more than two at an edge.
#include <algorithm>
#include <map>
#include <tuple>

#include "codegen/model.hpp"
#include "firmware/haptable_model.h"

namespace haptable {

namespace {

using Patch = std::array<std::uint16_t, 3>;

/// The patches around one vertex.
class Fan {
public:
    Fan(std::uint16_t vertex, const std::vector<std::uint16_t>& patches) : vertex_(vertex), patches_(patches) {}

    /// The lowest patch that each one reaches from it over edges at the vertex.
    std::vector<std::uint16_t> rings(const std::vector<Patch>& patch, const std::vector<Patch>& neighbour) const {
        std::map<std::uint16_t, std::uint16_t> ring;
        for (const std::uint16_t p : patches_) ring[p] = p;
        for (bool changed = true; changed;) {
            changed = false;
            for (const std::uint16_t p : patches_)
                for (std::size_t c = 0; c < 3; ++c) {
                    if (patch[p][c] == vertex_ || neighbour[p][c] == HAPTABLE_NONE) continue;
                    std::uint16_t& other = ring.at(neighbour[p][c]);
                    const std::uint16_t lowest = std::min(ring[p], other);
                    changed |= ring[p] != lowest || other != lowest;
                    ring[p] = other = lowest;
                }
        }
        std::vector<std::uint16_t> result;
        for (const std::uint16_t p : patches_) result.push_back(ring[p]);
        return result;
    }

    /// True when more than two of the patches have one edge at the vertex.
    bool has_crowded_edge(const std::vector<Patch>& patch) const {
        std::map<std::uint16_t, int> patches_at;
        for (const std::uint16_t p : patches_)
            for (const std::uint16_t v : patch[p])
                if (v != vertex_ && ++patches_at[v] > 2) return true;
        return false;
    }

private:
    std::uint16_t vertex_;
    const std::vector<std::uint16_t>& patches_;
};

}  // namespace

std::vector<haptable_hinge> build_hinges(std::size_t vertices, const std::vector<Patch>& patch,
                                         const std::vector<Patch>& neighbour) {
    std::vector<std::vector<std::uint16_t>> around(vertices);
    for (std::size_t p = 0; p < patch.size(); ++p)
        for (const std::uint16_t v : patch[p]) around[v].push_back(static_cast<std::uint16_t>(p));
    std::vector<haptable_hinge> hinges;
    for (std::size_t v = 0; v < vertices; ++v) {
        const auto vertex = static_cast<std::uint16_t>(v);
        const Fan fan(vertex, around[v]);
        const std::vector<std::uint16_t> ring = fan.rings(patch, neighbour);
        const bool is_single = std::equal(ring.begin() + !ring.empty(), ring.end(), ring.begin());
        if (is_single && !fan.has_crowded_edge(patch)) continue;
        for (std::size_t i = 0; i < ring.size(); ++i) hinges.push_back({vertex, around[v][i], ring[i]});
    }
    std::sort(hinges.begin(), hinges.end(), [](const haptable_hinge& a, const haptable_hinge& b) {
        return std::tie(a.vertex, a.ring, a.patch) < std::tie(b.vertex, b.ring, b.patch);
    });
    return hinges;
}

}  // namespace haptable
