// SPDX-License-Identifier: GPL-2.0-or-later
// Two fingers on one body: the pair's forces, energies and god-objects.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <random>

#include "codegen/in_memory.hpp"
#include "codegen/pair.hpp"
#include "firmware/haptable_bounds.h"
#include "firmware/haptable_points.h"
#include "host/precompute/precompute.hpp"
#include "tests/bodies.hpp"
#include "tests/dense.hpp"
#include "tests/finger.hpp"
#include "tests/firmware/ways.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Vector6d = Eigen::Vector<double, 6>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A body for two, with what its servo holds.
class Pair {
public:
    Pair(const ElasticBody& body, GodObject god_object, double friction = 0.0, bool passivity = false,
         const StiffeningCurve& curve = {})
        : body_(body),
          tables_(body.tables({god_object, friction, passivity})),
          servo_(body.servo()),
          pair_(build_pair(body.pair(), tables_, servo_)) {
        tables_.stiffening = curve;
        if (curve.energy_j > 0.0) servo_.stiffening = stiffening_table(curve);
        model_ = model_in_memory(tables_, servo_);
        pair_model_ = pair_in_memory(pair_, tables_, model_);
        begin();
    }
    Pair(const Pair&) = delete;
    Pair& operator=(const Pair&) = delete;

    void begin() { haptable_pair_init(&pair_model_, &state_); }
    /// Puts a god-object there, the finger having been at x.
    void put(int finger, int patch, const Vector3d& alpha, const Vector3d& x) {
        haptable_servo& servo = state_.servo[finger];
        servo.contact = contact_at(body_, patch, alpha);
        for (int c = 0; c < 3; ++c) servo.finger_m[c] = float(x[c]);
        servo.finger_known = 1;
        servo.state = HAPTABLE_CONTACT;
        state_.touches[finger] = 1;
    }
    void to(const Vector3d& x, const Vector3d& y) {
        const Eigen::Vector3f first = x.cast<float>(), second = y.cast<float>();
        haptable_pair_step(&pair_model_, &state_, first.data(), second.data(), time_us_ += HAPTABLE_TICK_US, out);
        at[0] = first.cast<double>();
        at[1] = second.cast<double>();
    }
    /// Puts both, and lets the tick see them.
    void put_both(int p, const Vector3d& alpha, const Vector3d& x, int q, const Vector3d& beta, const Vector3d& y) {
        begin();
        put(0, p, alpha, x);
        put(1, q, beta, y);
        to(x, y);
    }
    Vector3d force(int finger) const { return to_vector(out[finger].force_n); }
    Vector3d u(int finger) const { return at[finger] - to_vector(out[finger].god_object_m); }
    bool touches(int finger) const { return state_.touches[finger] != 0; }
    bool both_touch() const { return touches(0) && touches(1); }
    /// Of both fingers, one behind the other.
    Vector6d forces() const { return (Vector6d() << force(0), force(1)).finished(); }
    Vector6d dents() const { return (Vector6d() << u(0), u(1)).finished(); }
    double energy() const { return double(state_.energy_j); }
    const haptable_pair& state() const { return state_; }
    haptable_pair& state() { return state_; }
    const haptable_pair_model& model() const { return pair_model_; }
    void blocks_by(haptable_pair_blocks_fn* blocks) { pair_model_.blocks = blocks; }

    haptable_output out[2]{};
    Vector3d at[2];

private:
    const ElasticBody& body_;
    Tables tables_;
    ServoModel servo_;
    ServoPair pair_;
    haptable_model model_{};
    haptable_pair_model pair_model_{};
    haptable_room room_{};
    haptable_pair& state_ = room_.fingers;
    std::uint32_t time_us_ = 0;
};

/// The paper's cube for two, made once for each force; the mask has 10 mm.
const ElasticBody& cube_of(ForceLaw force) {
    if (force != ForceLaw::kInterpolated) return coupled_cube(force);
    static const ElasticBody interpolated(for_two(cube_scene(5, 0.3)), force);
    return interpolated;
}

/// C of two contacts by L from solves, as docs/MOVING.md has it.
class Direct {
public:
    explicit Direct(const ElasticBody& body) : body_(body) {}

    Matrix3d own(const haptable_contact& at) const {
        if (is_interpolated()) {
            Matrix3d sum = Matrix3d::Zero();
            for (int c = 0; c < 3; ++c) sum += double(at.alpha[c]) * stiffness(at, c);
            return sum.inverse();
        }
        // Lifted in its mean to the rigid stiffness of fixed nodes.
        const Matrix3d own = body_.coupling(at, at);
        double fixed = 0.0;
        for (int c = 0; c < 3; ++c)
            if (!is_free(at, c)) fixed += double(at.alpha[c]);
        const double missing = fixed / rigid() - own.trace() / 3.0;
        return fixed > 0.0 && missing > 0.0 ? Matrix3d(own + missing * Matrix3d::Identity()) : own;
    }
    Matrix6d compliance(const haptable_contact& a, const haptable_contact& b, double meeting_m) const {
        Matrix3d x = is_interpolated() ? interpolated(a, b) : body_.coupling(a, b);
        const double apart2 = (to_vector(a.god_object_m) - to_vector(b.god_object_m)).squaredNorm();
        const double near = std::max(0.0, 1.0 - apart2 / (meeting_m * meeting_m));
        x *= 1.0 - 0.125 * near * near;
        Matrix6d c;
        c << own(a), x, x.transpose(), own(b);
        return c;
    }

private:
    bool is_interpolated() const { return body_.tables().force == ForceLaw::kInterpolated; }
    double rigid() const { return body_.tables().rigid_stiffness_n_per_m; }
    std::size_t vertex(const haptable_contact& at, int c) const { return body_.vertex(at.patch, c); }
    bool is_free(const haptable_contact& at, int c) const { return body_.is_free(vertex(at, c)); }
    Matrix3d l(std::size_t i, std::size_t j) const {
        return body_.compliance().block<3, 3>(3 * Eigen::Index(i), 3 * Eigen::Index(j));
    }
    Matrix3d stiffness(const haptable_contact& at, int c) const {
        if (!is_free(at, c)) return rigid() * Matrix3d::Identity();
        return l(vertex(at, c), vertex(at, c)).inverse();
    }
    /// Each corner bears its part of the load by its stiffness.
    Matrix3d interpolated(const haptable_contact& a, const haptable_contact& b) const {
        const auto part = [this](const haptable_contact& at, int c) {
            return Matrix3d(double(at.alpha[c]) * stiffness(at, c) * own(at));
        };
        Matrix3d x = Matrix3d::Zero();
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                if (is_free(a, i) && is_free(b, j))
                    x += part(a, i).transpose() * l(vertex(a, i), vertex(b, j)) * part(b, j);
        return x;
    }

    const ElasticBody& body_;
};

struct Errors {
    double worst = 0.0;
    int both = 0, alone = 0, meeting = 0;
};

/// Forces at random pairs of places against direct solves, by what the condition allows.
Errors compare_forces(const ElasticBody& body, int pairs) {
    Pair pair(body, GodObject::kNearest);
    const Direct direct(body);
    std::mt19937 random(5);
    std::uniform_int_distribution<int> any(0, body.patches() - 1);
    std::uniform_real_distribution<double> depth(1e-4, 1e-3);
    const auto meeting_m = double(pair.model().meeting_m);
    Errors errors;
    while (errors.both + errors.alone < pairs) {
        pair.begin();
        Vector3d x[2];
        for (int finger = 0; finger < 2; ++finger) {
            const int patch = any(random);
            const Vector3d alpha = random_alpha(random);
            x[finger] = body.point(patch, alpha) - depth(random) * body.normal(patch);
            pair.put(finger, patch, alpha, x[finger]);
        }
        pair.to(x[0], x[1]);
        if (pair.out[0].state != HAPTABLE_CONTACT || pair.out[1].state != HAPTABLE_CONTACT) continue;
        const haptable_contact &a = pair.state().servo[0].contact, &b = pair.state().servo[1].contact;
        const Vector6d felt = pair.forces(), u = pair.dents();
        Vector6d wanted = Vector6d::Zero();
        const Matrix6d c = direct.compliance(a, b, meeting_m);
        const Eigen::VectorXd value = dense::eigenvalues(c);
        // Two places that load one node alone: C is singular, and the servo lifts it (see below).
        if (!(value[0] > 1e-12 * value[5])) continue;
        const double condition = value[5] / value[0];
        if (pair.both_touch()) {
            wanted = -dense::solve(c, u);
            ++errors.both;
        } else {
            const int one = pair.touches(0) ? 0 : 1;
            wanted.segment<3>(3 * one) = -direct.own(one == 0 ? a : b).inverse() * u.segment<3>(3 * one);
            ++errors.alone;
        }
        errors.meeting += (to_vector(a.god_object_m) - to_vector(b.god_object_m)).norm() < meeting_m ? 1 : 0;
        const double error = (felt - wanted).norm() / wanted.norm();
        errors.worst = std::max(errors.worst, error);
        if (pair.model().place_count > 0) continue;  // not all pairs
        // The rounding of a 6x6 by blocks of rounded numbers, and the place's own over the depth.
        EXPECT_WITHIN(error, .count = 32, .epsilon = kFloat,
                      .condition = condition + body.size() / pair.u(0).norm() + body.size() / pair.u(1).norm())
            << errors.both;
    }
    testing::Test::RecordProperty(std::string("worst, ") + word(body.tables().force),
                                  std::to_string(1e6 * errors.worst) + "e-6");
    return errors;
}

/// So many random pairs of places; HAPTABLE_RANDOM_PAIRS=10000: as many as docs/MOVING.md says on the
/// mouse, then of all forces.
int random_pairs(int in_the_suite) {
    const char* text = std::getenv("HAPTABLE_RANDOM_PAIRS");
    return text == nullptr ? in_the_suite : std::atoi(text);
}

TEST(Pair, ForcesAreThoseOfDirectSolvesOnTheCube) {
    for (const ForceLaw force : kForces) {
        const Errors errors = compare_forces(cube_of(force), random_pairs(10000));
        EXPECT_LT(errors.worst, 1e-5) << force;
        EXPECT_GT(errors.both, 2000);
        EXPECT_GT(errors.meeting, 0);
    }
}

TEST(Pair, ForcesAreThoseOfDirectSolvesOnTheMouse) {
    const int pairs = random_pairs(1000);
    for (const ForceLaw force : kForces) {
        if (force != ForceLaw::kInterpolated && pairs <= 1000) continue;
        const Errors errors = compare_forces({for_two(mouse_scene(true)), force, 0.004}, pairs);
        EXPECT_LT(errors.worst, 1e-5) << force;
        EXPECT_GT(errors.both, 700);
    }
}

/// Of some 2 mm of a dent 2.5 times as stiff, with a tangent of 6.
constexpr StiffeningCurve kStiff{{0.5, -0.5, 1.5}, 5e-5};

/// Presses both, 1.4 mm and 2 mm deep, at places that friction holds; then moves each.
void press_both(Pair& pair, const Vector3d& way, const Vector3d& beside = Vector3d::Zero()) {
    pair.begin();
    const Vector3d x(0.0091, 0.0112, 0.0301), y(0.0212, 0.0193, 0.0301);
    for (int i = 0; i <= 150; ++i) {
        const double down = 1e-5 * std::min(i, 100), aside = std::max(0, i - 100) / 50.0;
        pair.to(x - 1.5 * down * Vector3d::UnitZ() + aside * way, y - 2.1 * down * Vector3d::UnitZ() + aside * beside);
    }
}

// F = -dE/dx of fingers whose god-objects stay, E of both; and alike which of them is the first.
TEST(Pair, ForcesOfDentsThatStiffenAreTheSlopeOfOneEnergy) {
    for (const ForceLaw force : kForces)
        for (const GodObject god_object : every<GodObject>()) {
            SCOPED_TRACE(std::string(word(force)) + " " + word(god_object));
            const ElasticBody& body = cube_of(force);
            Pair pair(body, god_object, 50.0, false, kStiff), linear(body, god_object, 50.0);
            const Vector3d way(4e-4, -2e-4, 0.0);
            press_both(linear, way);
            press_both(pair, way);
            const Vector3d felt[2] = {pair.force(0), pair.force(1)};
            EXPECT_GT(felt[0].norm(), 1.1 * linear.force(0).norm());
            EXPECT_GT(felt[1].norm(), 1.3 * linear.force(1).norm());
            const double size = felt[0].norm() + felt[1].norm(), h = 1e-4;
            for (int f = 0; f < 2; ++f)
                for (int c = 0; c < 3; ++c) {
                    const auto stored = [&](double step) {
                        press_both(pair, way + (f == 0 ? step : 0.0) * Vector3d::Unit(c),
                                   (f == 1 ? step : 0.0) * Vector3d::Unit(c));
                        return pair.energy();
                    };
                    const auto slope = [&](double step) { return (stored(step) - stored(-step)) / (2.0 * step); };
                    // Differences over h and half of it; the energy's own roundings over h.
                    EXPECT_WITHIN(std::abs((4.0 * slope(h / 2) - slope(h)) / 3.0 + felt[f][c]), .epsilon = 3e-3,
                                  .size = size)
                        << f << " " << c;
                }
        }
}

/// Both fingers in, and around a closed path each.
struct PairLoops {
    double worst = -1.0;  ///< most given over most stored
    int loops = 0;
    int followed = 0, reused = 0;  ///< ticks that both rested together; of these, by the curvature of a tick before
    int most = 0;                  ///< in a row by one curvature
};

/// Each finger on an ellipse of its own in a plane at a depth, after it came in along the normal.
PairLoops run_loops(const ElasticBody& body, int loops, double deep_m, double wide_m, int ticks,
                    const StiffeningCurve& curve = {}) {
    Pair pair(body, GodObject::kLeastEnergy, 0.0, false, curve);
    std::mt19937 random(11);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    PairLoops result;
    while (result.loops < loops) {
        Vector3d x[2], n[2], along[2], beside[2];
        double phase[2], deep[2];
        for (int finger = 0; finger < 2; ++finger) {
            const int patch = std::uniform_int_distribution<int>(0, body.patches() - 1)(random);
            n[finger] = body.normal(patch);
            x[finger] = body.point(patch, random_alpha(random)) + 1e-4 * n[finger];
            along[finger] = wide_m * uniform(random) * n[finger].unitOrthogonal();
            beside[finger] = wide_m * uniform(random) * n[finger].cross(n[finger].unitOrthogonal());
            phase[finger] = 6.28 * uniform(random);
            deep[finger] = deep_m * (0.3 + 0.7 * uniform(random));
        }
        pair.begin();
        Work work[2];
        double stored = 0.0;
        bool both = true;
        const auto at = [&](int finger, double t, double depth) {
            const double a = 2 * M_PI * t;
            return Vector3d(x[finger] - depth * deep[finger] * n[finger] +
                            (std::cos(a + phase[finger]) - std::cos(phase[finger])) * along[finger] +
                            std::sin(a) * beside[finger]);
        };
        const auto go = [&](const Vector3d& a, const Vector3d& b) {
            pair.to(a, b);
            for (int finger = 0; finger < 2; ++finger) work[finger].add(pair.at[finger], pair.force(finger));
            stored = std::max(stored, pair.energy());
            both = both && pair.both_touch();
            const int by_one = pair.state().is_following;
            result.followed += by_one > 0;
            result.reused += by_one > 1;
            result.most = std::max(result.most, by_one);
        };
        pair.to(x[0], x[1]);
        for (int i = 1; i <= ticks / 4; ++i) go(at(0, 0, 4.0 * i / ticks), at(1, 0, 4.0 * i / ticks));
        // Where both god-objects have come to rest, around, and to rest again.
        for (int i = 0; i < 50; ++i) go(at(0, 0, 1), at(1, 0, 1));
        const double before = pair.energy() + work[0].given_j + work[1].given_j;
        both = true;
        for (int i = 1; i <= ticks; ++i) go(at(0, double(i) / ticks, 1), at(1, double(i) / ticks, 1));
        for (int i = 0; i < 50; ++i) go(at(0, 1, 1), at(1, 1, 1));
        if (stored < 1e-7 || !both) continue;
        // What is left there may be another minimum's.
        const double given = pair.energy() + work[0].given_j + work[1].given_j - before;
        ++result.loops;
        result.worst = std::max(result.worst, given / stored);
    }
    return result;
}

// Slowly; and at a hand's speed, 500 ticks around an ellipse of at most 25 mm, where both god-objects of a tick rest
// together.
TEST(Pair, ClosedLoopsOfBothGiveNoEnergy) {
    for (const ForceLaw force : kForces) {
        int followed = 0;
        for (const StiffeningCurve& curve : {StiffeningCurve{}, kStiff}) {
            SCOPED_TRACE(std::string(word(force)) + (curve.energy_j > 0.0 ? ", stiffens" : ""));
            EXPECT_LT(run_loops(cube_of(force), 12, 0.003, 0.004, 12800, curve).worst, 1e-3);
            const PairLoops fast = run_loops(cube_of(force), 24, 0.003, 0.004, 500, curve);
            EXPECT_LT(fast.worst, 1e-3);
            EXPECT_GT(fast.followed, followed / 2);
            if (curve.energy_j > 0.0) continue;
            followed = fast.followed;
            EXPECT_GT(fast.reused, followed / 2);
            EXPECT_LE(fast.most, HAPTABLE_PAIR_REUSED);
        }
    }
}

/// Both slide 1 mm deep over several patches of a cube's top, 50 um a tick. Of the ticks with both in contact, the part
/// in which neither took more than so many steps of the energy by itself.
double followed_part(ForceLaw force, double friction, unsigned most) {
    const ElasticBody& body = cube_of(force);
    Pair pair(body, GodObject::kLeastEnergy, friction);
    int ticks = 0, followed = 0;
    for (int i = 0; i < 400; ++i) {
        const double deep = std::min(1e-3, 2e-5 * i), along = 5e-5 * std::max(0, i - 50);
        for (haptable_servo& servo : pair.state().servo) servo.counters.most_energies = 0;
        pair.to({0.0061 + along, 0.0082 + 0.3 * along, 0.0301 - deep},
                {0.0242 - along, 0.0213 - 0.2 * along, 0.0301 - deep});
        if (!pair.both_touch()) continue;
        ++ticks;
        followed += std::ranges::all_of(pair.state().servo,
                                        [most](const auto& servo) { return servo.counters.most_energies <= most; });
    }
    EXPECT_GT(ticks, 300);
    return double(followed) / ticks;
}

// With friction it takes an evaluation where the minimum is foreseen, and one more for the load or over an edge; a
// descent takes more.
TEST(Pair, BothAreFollowedOverEdges) {
    for (const ForceLaw force : kForces) {
        EXPECT_GT(followed_part(force, 0.0, 0), 0.99) << force;
        EXPECT_GT(followed_part(force, 0.3, 2 * STEPS_OF_ENERGY), 0.8) << force;
    }
}

// The second comes in where the first's dent is deep: no energy is asked for where it would meet the surface.
TEST(Pair, AFingerFarBehindIsAtTheNearestPoint) {
    const ElasticBody& body = cube_of(ForceLaw::kConsistent);
    for (const double friction : {0.0, 0.5}) {
        Pair pair(body, GodObject::kLeastEnergy, friction);
        int behind = 0;
        for (int i = 0; i < 300; ++i) {
            const Vector3d second(0.0181, 0.0152, 0.0301 - 2e-6 * std::clamp(i - 150, 0, 100));
            for (haptable_servo& servo : pair.state().servo) servo.counters.most_energies = 0;
            const bool was_behind = haptable_touches(pair.out[1].state) && !pair.touches(1);
            pair.to({0.0126, 0.0152, 0.0301 - 3e-5 * std::min(i, 150)}, second);
            if (!was_behind || !haptable_touches(pair.out[1].state)) continue;
            ++behind;
            EXPECT_EQ(pair.state().servo[1].counters.most_energies, 0U) << i;
            EXPECT_EQ(pair.force(1).norm(), 0.0) << i;
            const Vector3d nearest(second.x(), second.y(), 0.03);
            EXPECT_WITHIN((to_vector(pair.out[1].god_object_m) - nearest).norm(), .count = 16, .epsilon = kFloat,
                          .size = body.size());
        }
        EXPECT_GT(behind, 50);
    }
}

TEST(Pair, EachFingerLetsGoOnItsOwn) {
    const ElasticBody& body = cube_of(ForceLaw::kConsistent);
    Pair pair(body, GodObject::kNearest);
    // The second rests a little in, the first presses ever deeper beside it: the surface leaves the second behind.
    const Vector3d first(0.0126, 0.0152, 0.0301), second(0.0181, 0.0152, 0.0301);
    double last = 0.0;
    int left = -1;
    for (int i = 0; i <= 500; ++i) {
        const double deep = 3e-6 * std::min(i, 100);
        pair.to(first - Vector3d(0, 0, deep + 5e-6 * std::max(0, i - 100)), second - Vector3d(0, 0, deep));
        if (i < 110) continue;
        ASSERT_TRUE(pair.touches(0)) << i;
        if (!pair.touches(1)) {
            if (left < 0) left = i;
            EXPECT_EQ(pair.force(1).norm(), 0.0) << i;  // and no suction
        } else {
            EXPECT_LT(left, 0) << i;
            last = pair.force(1).z();
            EXPECT_GT(last, -0.02 * pair.force(0).z()) << i;
        }
    }
    EXPECT_GT(left, 110);
    EXPECT_EQ(pair.out[1].state, HAPTABLE_CONTACT);  // its god-object stays
}

/// Bytes into which the masks' controls of the cube fit in clusters, and bytes into which only their nodes do.
constexpr std::uintmax_t kControlsFit = 1'000'000, kNodesFit = 90'000;

// By the servo's own numbers, beside direct solves; 1 % is what a compressed coupling may be off. Of masks the controls
// themselves are in clusters where these fit, as a tick reads fewer blocks then; also where a patch of wide ones loads
// more nodes than the servo has room for.
TEST(Pair, ForcesOfClustersAreWithinAHundredthOfDirectSolves) {
    struct Clustered {
        ForceLaw force;
        std::uintmax_t bytes;
        double mask_radius_m;
        bool are_nodes;  ///< those that masks load, not their controls
        int pairs;
    };
    for (const auto& [force, bytes, mask_radius_m, are_nodes, pairs] :
         {Clustered{ForceLaw::kInterpolated, 40'000, 0.0, false, random_pairs(1000)},
          {ForceLaw::kConsistent, 50'000, 0.0, false, random_pairs(1000)},
          {ForceLaw::kPressureMask, 70'000, 0.01, true, random_pairs(1000)},
          {ForceLaw::kPressureMask, kControlsFit, 0.01, false, random_pairs(300)},
          {ForceLaw::kPressureMask, 1'200'000, 0.03, false, 20}}) {
        SCOPED_TRACE(testing::Message() << force << " in " << bytes);
        const ElasticBody body(for_two(cube_scene(5, 0.3), bytes), force, mask_radius_m);
        const PairTables few = body.pair();
        ASSERT_FALSE(few.is_exact());
        EXPECT_EQ(few.clusters.load_begin.empty(), !are_nodes);
        EXPECT_EQ(few.clusters.places() < few.control_count, are_nodes);
        EXPECT_LE(pair_bytes(few), bytes);
        const Errors errors = compare_forces(body, pairs);
        EXPECT_GT(errors.worst, 1e-5);
        EXPECT_LT(errors.worst, 1e-2);
        EXPECT_GT(errors.both, pairs / 5);
    }
}

/// Any place of the surface, and how much of its patch's controls is loaded there.
haptable_pair_place any_place(const ElasticBody& body, int controls, std::mt19937& random) {
    const Vector3d alpha = random_alpha(random);
    haptable_pair_place place{};
    place.patch = std::uint16_t(std::uniform_int_distribution<int>(0, body.patches() - 1)(random));
    for (int c = 0; c < 3; ++c) {
        place.weight[c] = float(controls == 3 ? alpha[c] : alpha[c] * alpha[c]);
        if (controls > 3) place.weight[3 + c] = float(2.0 * alpha[(c + 1) % 3] * alpha[(c + 2) % 3]);
    }
    return place;
}

// A tool's points ask for sums over two patches' blocks, which are not written out one by one.
TEST(Pair, CouplesTwoPlacesByTheSumOfTheirBlocks) {
    constexpr std::pair<ForceLaw, std::uintmax_t> kForms[] = {{ForceLaw::kConsistent, kAllPairs},
                                                              {ForceLaw::kConsistent, 50'000},
                                                              {ForceLaw::kPressureMask, kAllPairs},
                                                              {ForceLaw::kPressureMask, kNodesFit},
                                                              {ForceLaw::kPressureMask, kControlsFit}};
    for (const auto& [force, bytes] : kForms) {
        const ElasticBody body(for_two(cube_scene(5, 0.3), bytes), force, 0.01);
        Pair pair(body, GodObject::kNearest);
        const haptable_pair_model& model = pair.model();
        haptable_points_model points{};
        haptable_points_model_make(&model, &points);
        std::mt19937 random(11);
        std::uniform_real_distribution<float> any(-1.0F, 1.0F);
        const int n = model.law->controls;
        double worst = 0.0;
        for (int trial = 0; trial < 300; ++trial) {
            const haptable_pair_place a = any_place(body, n, random);
            const haptable_pair_place b = any_place(body, n, random);
            std::array<std::array<float, 9>, 36> block{};
            model.blocks(&model, a.patch, b.patch, reinterpret_cast<float(*)[9]>(block.data()));
            const float v[3] = {any(random), any(random), any(random)}, w[3] = {any(random), any(random), any(random)};
            Matrix3d sum = Matrix3d::Zero();
            Vector6d q = Vector6d::Zero(), r = Vector6d::Zero();
            double size = 0.0;
            for (int k = 0; k < n; ++k)
                for (int l = 0; l < n; ++l) {
                    const auto at = std::size_t(k) * std::size_t(n) + std::size_t(l);
                    const Matrix3d c =
                        Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(block[at].data()).cast<double>();
                    const double along = to_vector(v).dot(c * to_vector(w));
                    sum += double(a.weight[k]) * double(b.weight[l]) * c;
                    q[k] += double(b.weight[l]) * along;
                    r[l] += double(a.weight[k]) * along;
                    size = std::max(size, c.cwiseAbs().maxCoeff());
                }
            float x[9], q_of[6] = {0.0F}, r_of[6] = {0.0F};
            points.couple(&model, &a, &b, x);
            points.pull(&model, &a, &b, v, w, q_of, r_of);
            for (int e = 0; e < 9; ++e) worst = std::max(worst, std::abs(double(x[e]) - sum(e / 3, e % 3)) / size);
            for (int k = 0; k < n; ++k)
                worst =
                    std::max({worst, std::abs(double(q_of[k]) - q[k]) / size, std::abs(double(r_of[k]) - r[k]) / size});
        }
        // Sums of up to 48 x 48 terms, each of some roundings, in other orders.
        EXPECT_LT(worst, 200 * kFloat) << force << " " << bytes;
        EXPECT_EQ(model.load_count > 0, bytes == kNodesFit);
        EXPECT_EQ(model.place_count > 0, bytes != kAllPairs);
    }
}

int blocks_read = 0;

void count_blocks(const haptable_pair_model* tables, std::uint16_t first, std::uint16_t second, float (*block)[9]) {
    ++blocks_read;
    haptable_pair_blocks_clusters(tables, first, second, block);
}

// Blocks of two patches in clusters are what a tick of two fingers costs most: one that settles both reads
// HAPTABLE_PAIR_READS, one that solves for both reads them where the fingers stay for a second tick.
TEST(Pair, FewBlocksOfClustersAreReadInATick) {
    const ElasticBody body(for_two(cube_scene(5, 0.3), 70'000), ForceLaw::kPressureMask, 0.01);
    for (const GodObject god : every<GodObject>()) {
        Pair pair(body, god);
        pair.blocks_by(count_blocks);
        std::mt19937 random(7);
        std::uniform_real_distribution<double> on_top(0.004, 0.026), inside(0.001, 0.004);
        Vector3d at[2] = {{0.008, 0.01, 0.031}, {0.021, 0.02, 0.031}}, to[2] = {at[0], at[1]};
        int both = 0, all = 0;
        for (int tick = 0; tick < 4000; ++tick) {
            for (int f = 0; f < 2; ++f) {
                if (tick % 20 == 10 * f) to[f] = Vector3d(on_top(random), on_top(random), 0.03 - inside(random));
                at[f] += 0.1 * (to[f] - at[f]);
            }
            blocks_read = 0;
            pair.to(at[0], at[1]);
            EXPECT_LE(blocks_read, HAPTABLE_PAIR_READS + (god == GodObject::kNearest ? 0 : 1)) << god << " " << tick;
            all += blocks_read;
            both += pair.both_touch();
        }
        EXPECT_GT(both, 2000) << god;
        EXPECT_GT(all, 100) << god;
    }
}

TEST(Pair, TheMouseHasAHundredthInTheBytesOfTheDefault) {
    for (const ForceLaw force : kForces) {
        if (force != ForceLaw::kConsistent && random_pairs(0) == 0) continue;
        Scene scene = for_two(mouse_scene(), TableOptions{}.coupling_bytes);
        scene.contact.force = force;
        scene.contact.mask_radius_m = force == ForceLaw::kPressureMask ? 0.006 : 0.0;
        scene.tables.columns = ColumnRows::kNone;
        const TemporaryFolder folder;
        Progress quiet(true);
        const Summary summary = precompute(scene, folder.path() / "out", quiet).summary;
        ASSERT_TRUE(summary.pair);
        EXPECT_LE(summary.pair->bytes, scene.tables.coupling_bytes);
        EXPECT_EQ(summary.pair->error.places, 10000U);
        EXPECT_GT(summary.pair->error.worst, 0.0);
        EXPECT_LT(summary.pair->error.worst, 0.01) << force;
        EXPECT_GT(summary.pair->error.least, 0.0) << force;
    }
}

// C of both is singular there: a 64th of C_11 is left, and the other's displacement is as large.
TEST(Pair, TwoPlacesThatLoadOneNodeAloneStayWellPosed) {
    const ElasticBody& body = cube_of(ForceLaw::kConsistent);
    for (const GodObject god_object : every<GodObject>()) {
        Pair pair(body, god_object), alone(body, god_object);
        int places = 0;
        for (int p = 0; p < body.patches(); ++p) {
            int free = -1, count = 0;
            for (int c = 0; c < 3; ++c)
                if (body.is_free(body.vertex(p, c))) {
                    free = c;
                    ++count;
                }
            if (count != 1) continue;
            Vector3d alpha = Vector3d::Constant(0.3), beta = Vector3d::Constant(1.5e-4);
            alpha[free] = 0.4;
            beta[free] = 0.9997;
            // By the first alone the surface goes down 2.5 times as far where the second is.
            const Vector3d down = -1e-3 * body.normal(p), x = body.point(p, alpha) + down;
            alone.begin();
            alone.put(0, p, alpha, x);
            alone.to(x, Vector3d::Constant(0.1));
            for (const double deeper : {2.4, 2.5, 2.6}) {
                pair.put_both(p, alpha, x, p, beta, body.point(p, beta) + deeper * down);
                EXPECT_LT(pair.force(0).norm(), 64.0 * 8.0 * alone.force(0).norm()) << god_object << " " << p;
                places += pair.both_touch();
            }
        }
        EXPECT_GT(places, 10) << god_object;
    }
}

}  // namespace
}  // namespace haptable::test
