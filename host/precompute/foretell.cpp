// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/foretell.hpp"

#include <algorithm>
#include <thread>

#include "host/body/rigid_body.hpp"
#include "host/inverse/cholmod_inverse.hpp"
#include "host/inverse/free_inverse.hpp"
#include "host/precompute/plan.hpp"
#include "host/precompute/requirements.hpp"

namespace haptable {

namespace {

Masks masks_of(const Scene& scene, const Body& body, Progress& progress) {
    Plan plan;
    Workers workers(static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
    if (scene.contact.force == ForceLaw::kPressureMask) plan_masks(scene, body, workers, progress, plan);
    return plan.masks;
}

}  // namespace

Foretold foretell(const Scene& scene, const Body& body, Progress& progress) {
    Foretold told{foresee_locking(scene, body.mesh), {}};
    const bool is_weighed = scene.gravity && !scene.free_body;
    if (told.locking.excess == 0.0 && !is_weighed) return told;
    CholmodInverse held;
    std::optional<FreeInverse> relieved;
    if (scene.free_body) {
        const RigidBody rigid = rigid_body_of(scene, body);
        relieved.emplace(held, rigid.motion, rigid.momentum);
    }
    Inverse& inverse = relieved ? static_cast<Inverse&>(*relieved) : held;
    const Stiffness k = assemble_held(scene, body);
    const MemoryNeed need = inverse.analyse(k, {});
    if (need.peak() > need.available && !is_weighed) return told;
    const FactorFacts facts = inverse.factorize(k, progress);
    require_pivots(scene, body, k, inverse, facts);
    const Masks masks = masks_of(scene, body, progress);
    told.locking = measure_locking(scene, body, masks, inverse);
    if (!is_weighed) return told;
    const std::vector<Eigen::Vector3d> sag_m = find_sag(scene, body, inverse);
    told.gravity = judge_gravity(scene, body, masks, inverse, sag_m, prestress_of(scene, body, sag_m));
    return told;
}

}  // namespace haptable
