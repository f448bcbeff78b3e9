// SPDX-License-Identifier: GPL-2.0-or-later
// Elastic bodies through the whole way: scene, precompute, tables, the servo's model. And what the servo's forces must
// agree with: L from plain solves, in double.
#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <random>
#include <string>

#include "codegen/loaded_scene.hpp"
#include "codegen/model.hpp"
#include "firmware/haptable_model.h"
#include "host/precompute/precompute.hpp"
#include "host/scene/scene.hpp"
#include "host/tables/pair.hpp"
#include "tests/cells.hpp"
#include "tests/temporary_folder.hpp"

namespace haptable::test {

inline constexpr auto kForces = every<ForceLaw>();
inline constexpr double kTop_m = 0.03;  ///< of the paper's cube

/// The paper's cube: its bottom held still. `top_only`: only the middle 22 mm of its top may be touched.
Scene cube_scene(int nodes_per_side, double poisson, bool top_only = false);
/// K of that cube's free nodes: n n (n - 1) of them, three rows each, N/m.
Eigen::SparseMatrix<double> cube_stiffness(int nodes_per_side, double poisson);
/// The mouse; `front_only`: only where x < 30 mm.
Scene mouse_scene(bool front_only = false);

/// Nothing holds it; of that density.
void set_free(Scene& scene, double density_kg_per_m3 = 1000.0);

/// A scene for two fingers; the coupling of all pairs of places, where it has no fewer bytes.
inline constexpr std::uintmax_t kAllPairs = 1'000'000'000;
Scene for_two(Scene scene, std::uintmax_t coupling_bytes = kAllPairs);

/// What precompute makes of a scene.
SceneFiles files_of(const Scene& scene);

Cells sphere_cells(int n, double radius);                               // a ball, its lower cap held
Cells plate_cells(int n, double side, double thickness);                // held at its rim
Cells needle_cells(int n, double length, double width);                 // a tapering tip upwards
Cells torus_cells(int around, int across, double major, double minor);  // lying on a held strip

/// How a test touches a body: without a release, and with no limits but those that it names.
struct TouchOptions {
    GodObject god_object = GodObject::kNearest;
    double friction = 0.0;
    bool passivity = false;
    double max_force_n = 1e6;
    SafetyLimits limits{};
};

class ElasticBody {
public:
    /// Runs precompute with this force, and with the radius where it is the pressure mask's; the god-object may be
    /// changed later.
    ElasticBody(Scene scene, ForceLaw force, double mask_radius_m = 0.0);
    ElasticBody(const Cells& cells, const std::string& name, ForceLaw force, double mask_radius_m = 0.0);
    ElasticBody(const ElasticBody&) = delete;
    ElasticBody& operator=(const ElasticBody&) = delete;

    const std::string& name() const { return tables_.name; }
    const Tables& tables() const { return tables_; }
    Tables tables(const TouchOptions& options) const;
    const ServoModel& servo() const { return servo_; }
    /// Of a scene with two fingers.
    PairTables pair() const { return *read_pair(folder_.path() / "out"); }
    /// The servo's model with the scene's force and this god-object.
    haptable_model model(GodObject god_object = GodObject::kNearest) const;
    /// L over the touchable free nodes, m/N, [3 n, 3 n] in the order of the vertices, by solves; made when first asked.
    const Eigen::MatrixXd& compliance() const;

    Eigen::Vector3d corner(int patch, int c) const;
    Eigen::Vector3d point(int patch, const Eigen::Vector3d& alpha) const;
    Eigen::Vector3d normal(int patch) const;
    double size() const { return static_cast<double>(servo_.tolerance_m) * 0x1p20; }
    std::size_t vertex(int patch, int c) const {
        return servo_.patch[static_cast<std::size_t>(patch)][static_cast<std::size_t>(c)];
    }
    bool is_free(std::size_t vertex) const { return vertex < servo_.free_count; }
    int patches() const { return static_cast<int>(servo_.patch.size()); }
    /// The load's share of every touchable free node at a point: alpha of the patch, or the mask; [n].
    Eigen::VectorXd weights(int patch, const Eigen::Vector3d& alpha) const;
    /// C between the places of two contacts, by the solves.
    Eigen::Matrix3d coupling(const haptable_contact& a, const haptable_contact& b) const;
    /// C = sum w_a w_b L_ab from the solves.
    Eigen::Matrix3d compliance_at(int patch, const Eigen::Vector3d& alpha) const;
    /// The patch (from outside upwards) over x, y, and its area coordinates there. -1 where there is none.
    int patch_over(double x, double y, Eigen::Vector3d& alpha) const;

private:
    void load(const Scene& scene);

    TemporaryFolder folder_;
    Tables tables_;
    ServoModel servo_;
    Scene scene_;
    mutable std::unique_ptr<Eigen::MatrixXd> compliance_;
};

/// The paper's cube, coupled at all pairs of its places: by consistent loads, or masks of 10 mm. Made once.
const ElasticBody& coupled_cube(ForceLaw force);

/// The body of a mode's tests, "cube" or "needle", with the tables of one force; made once for all of a program's
/// tests.
const ElasticBody& body_of_modes(const std::string& name, ForceLaw force);
/// A test's name of these words: only letters, digits and _ may be in it.
std::string test_name(std::string words);

/// Area coordinates, all of one probability.
Eigen::Vector3d random_alpha(std::mt19937& random);

/// A contact that stands at a point of a patch.
haptable_contact contact_at(const ElasticBody& body, int patch, const Eigen::Vector3d& alpha);

}  // namespace haptable::test
