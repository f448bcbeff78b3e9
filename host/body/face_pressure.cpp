// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/body/face_pressure.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "host/base/index.hpp"
#include "host/body/mask.hpp"

namespace haptable {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
// Cuts a patch into triangles whose edges are an eighth of the radius: then the rim, where the pressure's second
// derivative jumps, is hit within 1e-4 of the load.
constexpr double kTrianglesInRadius = 8.0;
constexpr int kMostCuts = 32;

/// The corners of a quarter in its face's barycentric coordinates, as quarters_of() has them.
std::array<Vector3d, 3> quarter_corners(int place) {
    const Vector3d a = Vector3d::UnitX(), b = Vector3d::UnitY(), c = Vector3d::UnitZ();
    const Vector3d ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
    const std::array<std::array<Vector3d, 3>, 4> corners{{{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}}};
    return corners[at(place)];
}

double longest_edge(const std::array<Vector3d, 3>& x) {
    return std::max({(x[1] - x[0]).norm(), (x[2] - x[1]).norm(), (x[0] - x[2]).norm()});
}

}  // namespace

/// The three points of each small triangle that are exact for quadratic functions.
Facets::Rule Facets::make_rule(int place, int cuts) {
    const std::array<Vector3d, 3> corner = quarter_corners(std::max(0, place));
    std::vector<Vector3d> points;
    const auto add = [&](int i, int j, int turn) {  // the triangle at (i, j) of the grid, pointing up or down
        const double low = turn > 0 ? 0.0 : 1.0;
        for (int far = 0; far < 3; ++far) {
            const double x = far == 1 ? 2.0 / 3.0 : 1.0 / 6.0, y = far == 2 ? 2.0 / 3.0 : 1.0 / 6.0;
            const double s = (i + low + turn * x) / cuts, t = (j + low + turn * y) / cuts;
            points.emplace_back(1.0 - s - t, s, t);
        }
    };
    for (int i = 0; i < cuts; ++i)
        for (int j = 0; i + j < cuts; ++j) {
            add(i, j, 1);
            if (i + j + 1 < cuts) add(i, j, -1);
        }
    Rule rule(static_cast<Index>(points.size()), place == kLinear ? 3 : 6);
    for (std::size_t k = 0; k < points.size(); ++k) {
        const auto row = static_cast<Index>(k);
        if (place == kLinear) {
            rule.row(row) = points[k];
            continue;
        }
        const Vector3d t = points[k][0] * corner[0] + points[k][1] * corner[1] + points[k][2] * corner[2];
        for (Index c = 0; c < 3; ++c) {
            rule(row, c) = t[c] * (2.0 * t[c] - 1.0);
            rule(row, 3 + c) = 4.0 * t[c] * t[(c + 1) % 3];
        }
    }
    return rule;
}

Facets::Facets(std::span<const Vector3d> position_m, std::span<const Patch> patch, std::span<const Quarter> quarter,
               double radius_m)
    : extent_m_(position_m.size(), 0.0), radius_m_(radius_m) {
    double longest_m = 0.0;
    for (std::size_t p = 0; p < patch.size(); ++p) {
        std::array<Vector3d, 3> x;
        for (std::size_t c = 0; c < 3; ++c) x[c] = position_m[at(patch[p][c])];
        const double edge_m = longest_edge(x);
        longest_m = std::max(longest_m, edge_m);
        const int cuts =
            static_cast<int>(std::clamp(std::ceil(kTrianglesInRadius * edge_m / radius_m), 1.0, double{kMostCuts}));
        const int place = quarter[p].is_whole ? quarter[p].place : kLinear;
        const auto [rule, is_new] = rule_.try_emplace({place, cuts});
        if (is_new) rule->second = make_rule(place, cuts);
        Facet& facet = facet_.emplace_back();
        facet.area_m2 = 0.5 * (x[1] - x[0]).cross(x[2] - x[0]).norm();
        facet.rule = &rule->second;
        facet.nodes = place == kLinear ? 3 : 6;
        if (place != kLinear)
            facet.node = quarter[p].face;
        else
            std::copy(patch[p].begin(), patch[p].end(), facet.node.begin());
        // From any node of a face to any other it is two edges of its quarters at most.
        const double extent_m = place == kLinear ? edge_m : 2.0 * edge_m;
        for (std::int32_t node : nodes(p)) extent_m_[at(node)] = std::max(extent_m_[at(node)], extent_m);
    }
    touched_m_ = std::hypot(radius_m, 0.5 * longest_m);
}

double Facets::reach_m(const SurfaceDistance::Distances& near) const {
    double reach_m = 0.0;
    for (const auto& [node, d] : near) reach_m = std::max(reach_m, d + extent_m_[at(node)]);
    return reach_m * (1.0 + 1e-12);  // that far, not within
}

std::span<const std::int32_t> Facets::nodes(std::size_t p) const {
    return std::span(facet_[p].node).first(facet_[p].nodes);
}

bool Facets::add(std::size_t p, std::span<const double> squared_m2, std::span<double> weight) const {
    const Rule& rule = *facet_[p].rule;
    const auto nodes = static_cast<Index>(squared_m2.size());
    bool is_loaded = false;
    std::fill(weight.begin(), weight.end(), 0.0);
    for (Index k = 0; k < rule.rows(); ++k) {
        double squared = 0.0;
        for (Index a = 0; a < nodes; ++a) squared += rule(k, a) * squared_m2[at(a)];
        const double rest = 1.0 - squared / (radius_m_ * radius_m_);
        if (!(rest > 0.0)) continue;
        is_loaded = true;
        for (Index a = 0; a < nodes; ++a) weight[at(a)] += rest * rest * rule(k, a);
    }
    for (double& w : weight) w *= facet_[p].area_m2 / static_cast<double>(rule.rows());
    return is_loaded;
}

FacePressure::FacePressure(const Facets& facets, const SurfaceGraph& surface)
    : facets_(&facets),
      surface_(&surface),
      squared_m2_(surface.turn.size(), kInfinite),
      weight_(surface.turn.size(), 0.0),
      seen_(surface.node.size() / 3, 0),
      loaded_(surface.turn.size(), 0) {}

/// Those at the nodes that are near, ascending.
void FacePressure::find_facets(const SurfaceDistance::Distances& near) {
    facet_.clear();
    for (const auto& [node, d] : near)
        for (std::int32_t k = surface_->around_begin[at(node)]; k < surface_->around_begin[at(node) + 1]; ++k) {
            const std::size_t p = at(surface_->around[at(k)]) / 3;
            if (seen_[p] == 0) facet_.push_back(p);
            seen_[p] = 1;
        }
    std::sort(facet_.begin(), facet_.end());
    for (std::size_t p : facet_) seen_[p] = 0;
}

NodeWeights FacePressure::integrate(const SurfaceDistance::Distances& near, std::size_t own) {
    NodeWeights sum;
    const auto within = std::count_if(near.begin(), near.end(),
                                      [&](const NodeDistance& n) { return n.distance_m < facets_->radius_m(); });
    if (at(within) <= own) return sum;
    for (const auto& [node, d] : near) squared_m2_[at(node)] = d * d;
    find_facets(near);
    for (std::size_t p : facet_) {
        const std::span<const std::int32_t> node = facets_->nodes(p);
        std::array<double, 6> squared{}, weight{};
        for (std::size_t a = 0; a < node.size(); ++a) squared[a] = squared_m2_[at(node[a])];
        const bool is_near = std::all_of(squared.begin(), squared.end(), [](double d) { return d < kInfinite; });
        if (!is_near || !facets_->add(p, std::span(squared).first(node.size()), std::span(weight).first(node.size())))
            continue;
        for (std::size_t a = 0; a < node.size(); ++a) {
            weight_[at(node[a])] += weight[a];
            loaded_[at(node[a])] = 1;
        }
    }
    for (const auto& [node, d] : near) {
        squared_m2_[at(node)] = kInfinite;
        if (loaded_[at(node)] == 0) continue;
        sum.node.push_back(node);
        sum.weight.push_back(weight_[at(node)]);
        weight_[at(node)] = 0.0;
        loaded_[at(node)] = 0;
    }
    return sum;
}

}  // namespace haptable
