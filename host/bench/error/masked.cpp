// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/error/masked.hpp"

#include <Eigen/Dense>

#include "host/base/process_cost.hpp"
#include "host/bench/error/mask_load.hpp"
#include "host/inverse/cholmod_inverse.hpp"
#include "host/precompute/assembly.hpp"

namespace haptable {

namespace {

Masks masks_of(const Body& body, double radius_m) {
    Workers workers(1);
    Progress quiet(true);
    return make_masks(body.mesh.position_m, body.touch_patch, radius_m, workers, quiet, body.touch_quarter);
}

}  // namespace

std::vector<Finger> fingers_at(std::span<const Place> places, double radius_m) {
    std::vector<Finger> fingers;
    for (const Place& place : places) fingers.push_back({radius_m, place});
    return fingers;
}

Masked::Masked(Scene scene, Element element, std::span<const Finger> fingers) : scene_(std::move(scene)) {
    scene_.mesh.element = element;
    scene_.contact.mask_radius_m = fingers.front().radius_m;
    body_ = make_body(scene_, make_mesh(scene_.mesh));
    for (const auto& [radius_m, place] : fingers) {
        if (!masks_.contains(radius_m)) masks_.emplace(radius_m, masks_of(body_, radius_m));
        const auto [patch, alpha] = locate(body_.mesh.position_m, body_.touch_patch, place.on_m);
        load_.push_back(mask_load(masks_.at(radius_m), patch, alpha));
        outward_.push_back(place.outward);
    }
}

Masked::Felt Masked::at(double poisson) {
    scene_.material.poisson = poisson;
    const Stiffness k = assemble_free(scene_, body_);
    std::vector<NodePair> blocks;
    for (std::int32_t node : body_.touch_node) {
        const std::int32_t i = body_.unknown[static_cast<std::size_t>(node)];
        blocks.push_back({i, i});
    }
    Felt felt;
    Progress quiet(true);
    const double begin = process_cost().cpu_s;
    CholmodInverse inverse(1);
    inverse.analyse(k, {{blocks}, {}, {}, false, 3});
    inverse.factorize(k, quiet);
    inverse.blocks(blocks, Precision::kDouble, quiet);
    felt.cpu_s = process_cost().cpu_s - begin;
    felt.told = measure_locking(scene_, body_, masks_.at(scene_.contact.mask_radius_m), inverse);
    const std::vector<Eigen::Matrix3d> c = compliances(inverse, load_, body_.unknown);
    for (std::size_t i = 0; i < c.size(); ++i)
        felt.normal_n_per_m.push_back(outward_[i].dot(c[i].inverse() * outward_[i]));
    return felt;
}

double Masked::foreseen_at(double poisson) {
    scene_.material.poisson = poisson;
    return foresee_locking(scene_, body_.mesh).excess;
}

double excess(std::span<const double> felt, std::span<const double> body) {
    double sum = 0.0;
    for (std::size_t i = 0; i < felt.size(); ++i) sum += felt[i] / body[i] - 1.0;
    return sum / static_cast<double>(felt.size());
}

}  // namespace haptable
