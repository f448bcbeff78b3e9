// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/error/contact_error.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>

#include "host/base/error.hpp"
#include "host/bench/contact/bodies.hpp"
#include "host/bench/error/mask_load.hpp"
#include "host/bench/subject.hpp"
#include "host/inverse/factor.hpp"
#include "host/precompute/assembly.hpp"
#include "host/precompute/body.hpp"

namespace haptable {

namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kDepth = 0.001;  // m

/// The mesh, its factor, and what happens under loads on it.
class DiscreteBody {
public:
    explicit DiscreteBody(const Scene& scene, double radius_m)
        : body_(make_body(scene, make_mesh(scene.mesh))),
          factor_(assemble_free(scene, body_)),
          masks_(masks_on(body_.mesh.position_m, body_.touch_patch, radius_m)),
          radius_m_(radius_m) {}

    std::pair<Patch, Vector3d> at(const Vector3d& x_m) const {
        return locate(body_.mesh.position_m, body_.touch_patch, x_m);
    }
    LoadShares point(const Patch& patch, const Vector3d& alpha) const {
        return {{patch[0], alpha[0]}, {patch[1], alpha[1]}, {patch[2], alpha[2]}};
    }
    /// The mask's weights as the tables have them: a quadratic on every patch.
    LoadShares mask(const Patch& patch, const Vector3d& alpha) const { return mask_load(masks_, patch, alpha); }
    /// The finger's own pressure, integrated over the patches.
    LoadShares pressure(const Vector3d& x_m) const {
        return shares_on(body_.mesh.position_m, body_.touch_patch, {x_m, radius_m_});
    }
    Matrix3d stiffness(const LoadShares& shares) const {
        return compliances(factor_, std::span(&shares, 1), body_.unknown).front().inverse();
    }
    /// u at the shares under forces on nodes.
    Vector3d moved(const std::map<std::int32_t, Vector3d>& forces, const LoadShares& at) const {
        Eigen::MatrixXd b = Eigen::MatrixXd::Zero(factor_.size(), 1), x;
        for (const auto& [node, force] : forces)
            if (const std::int32_t i = unknown(node); i >= 0) b.block<3, 1>(Index{3} * i, 0) += force;
        factor_.solve(b, x);
        Vector3d u = Vector3d::Zero();
        for (const auto& [node, share] : at)
            if (const std::int32_t i = unknown(node); i >= 0) u += share * x.block<3, 1>(Index{3} * i, 0);
        return u;
    }
    /// (L_ii)^-1 of a node.
    Matrix3d node_stiffness(std::int32_t node) const { return stiffness({{node, 1.0}}); }

private:
    std::int32_t unknown(std::int32_t node) const { return body_.unknown[static_cast<std::size_t>(node)]; }

    Body body_;
    Factor factor_;
    Masks masks_;
    double radius_m_;
};

/// The largest over the places.
struct Errors {
    double rounding = 0.0, imposed = 0.0, missed = 0.0;
};

void add_place(const DiscreteBody& body, ForceLaw force, const Place& place, const Vector3d& felt_n, Errors& errors) {
    const auto [patch, alpha] = body.at(place.on_m);
    const LoadShares point = body.point(patch, alpha);
    const Vector3d u = -kDepth * place.outward;
    const bool mask = force == ForceLaw::kPressureMask;
    const LoadShares shares = mask ? body.mask(patch, alpha) : point;
    std::map<std::int32_t, Vector3d> loads;
    if (force == ForceLaw::kInterpolated)
        for (const auto& [node, share] : shares) loads[node] = share * (body.node_stiffness(node) * u);
    else
        for (const auto& [node, share] : shares) loads[node] = share * (body.stiffness(shares) * u);
    Vector3d own = Vector3d::Zero();
    for (const auto& [node, load] : loads) own -= load;
    const LoadShares imposed = mask ? body.pressure(place.on_m) : point;
    const Vector3d meant = -(body.stiffness(imposed) * u);
    errors.rounding = std::max(errors.rounding, (felt_n - own).norm() / own.norm());
    errors.imposed = std::max(errors.imposed, (felt_n - meant).norm() / meant.norm());
    errors.missed = std::max(errors.missed, (body.moved(loads, shares) - u).norm() / u.norm());
}

}  // namespace

std::vector<std::vector<Cell>> contact_errors(const Specimen& specimen, const Meshed& meshed,
                                              const std::vector<Truth>& truths, const std::filesystem::path& build) {
    const DiscreteBody body(meshed.scene, specimen.finger_radius_m);
    std::vector<std::vector<Cell>> rows;
    for (std::size_t mode : {0U, 1U, 2U}) {
        const auto subject = touched_as(meshed.scene, kContactModes[mode], specimen.finger_radius_m, build / "contact");
        BenchFinger finger(bare(subject->model()));
        Errors errors;
        for (const Truth& truth : truths) {
            const Place& place = truth.place;
            finger.begin();
            finger.to(place.on_m + kDepth * place.outward);
            const Vector3d felt = finger.to(place.on_m - kDepth * place.outward);
            if (!finger.touches()) throw Error("the bench's finger lost contact: nothing was measured");
            add_place(body, kContactModes[mode].force, place, felt, errors);
        }
        const auto share = [](double value) {
            return value < 1e-3 ? error_of(value) : number(value, fmt::format("{:.2g} %", 100.0 * value));
        };
        rows.push_back({fmt::format("{}, {}", specimen.name, meshed.name), word(kContactModes[mode].force),
                        error_of(errors.rounding), share(errors.imposed), share(errors.missed)});
    }
    return rows;
}

NumberTable contact_error_table(std::vector<std::vector<Cell>> rows) {
    return {{"body", "force", "float32 against its own equations in double", "against that contact imposed",
             "the drawn surface misses the finger by, of the depth"},
            std::move(rows)};
}

}  // namespace haptable
