// SPDX-License-Identifier: GPL-2.0-or-later
// Two fingers on one body: the pair's forces, energies and god-objects.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>

#include "codegen/in_memory.hpp"
#include "codegen/pair.hpp"
#include "firmware/haptable_bounds.h"
#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/link/finger_path.hpp"
#include "host/precompute/precompute.hpp"
#include "host/session/servo/replay.hpp"
#include "tests/bodies.hpp"
#include "tests/dense.hpp"
#include "tests/error_of.hpp"
#include "tests/finger.hpp"
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
        float finger_m[2][3];
        for (int c = 0; c < 3; ++c) {
            finger_m[0][c] = float(x[c]);
            finger_m[1][c] = float(y[c]);
        }
        haptable_pair_step(&pair_model_, &state_, finger_m[0], finger_m[1], time_us_ += HAPTABLE_TICK_US, out);
        at[0] = to_vector(finger_m[0]);
        at[1] = to_vector(finger_m[1]);
    }
    Vector3d force(int finger) const { return to_vector(out[finger].force_n); }
    Vector3d u(int finger) const { return at[finger] - to_vector(out[finger].god_object_m); }
    bool touches(int finger) const { return state_.touches[finger] != 0; }
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

/// C between two places by L from solves, as docs/MOVING.md has it.
class Direct {
public:
    Direct(const ElasticBody& body, ForceLaw force) : body_(body), force_(force) {}

    struct Place {
        Eigen::MatrixXd share;  // [3 n, 3]: nodal forces of a load
        Matrix3d own;
        Vector3d at;
    };
    Place place(int patch, const Vector3d& alpha) const {
        Place to;
        to.at = body_.point(patch, alpha);
        const Eigen::VectorXd w = body_.weights(patch, alpha);
        to.share = Eigen::MatrixXd::Zero(3 * w.size(), 3);
        if (force_ == ForceLaw::kInterpolated) return interpolated(patch, alpha, to);
        std::vector<Eigen::Index> loaded;
        for (Eigen::Index i = 0; i < w.size(); ++i)
            if (w[i] != 0.0) loaded.push_back(i);
        for (const Eigen::Index i : loaded) to.share.middleRows<3>(3 * i) = w[i] * Matrix3d::Identity();
        to.own.setZero();
        for (const Eigen::Index i : loaded)
            for (const Eigen::Index j : loaded) to.own += w[i] * w[j] * l(i, j);
        lift(patch, alpha, to.own);
        return to;
    }
    Matrix6d compliance(const Place& a, const Place& b, double meeting_m) const {
        Matrix3d x = Matrix3d::Zero();
        const auto loads = [](const Place& place) {
            std::vector<Eigen::Index> node;
            for (Eigen::Index i = 0; i < place.share.rows() / 3; ++i)
                if (!place.share.middleRows<3>(3 * i).isZero(0.0)) node.push_back(i);
            return node;
        };
        const auto first = loads(a), second = loads(b);
        for (const Eigen::Index i : first)
            for (const Eigen::Index j : second)
                x += a.share.middleRows<3>(3 * i).transpose() * l(i, j) * b.share.middleRows<3>(3 * j);
        const double near = std::max(0.0, 1.0 - (a.at - b.at).squaredNorm() / (meeting_m * meeting_m));
        x *= 1.0 - 0.125 * near * near;
        Matrix6d c;
        c << a.own, x, x.transpose(), b.own;
        return c;
    }

private:
    Matrix3d l(Eigen::Index i, Eigen::Index j) const { return body_.compliance().block<3, 3>(3 * i, 3 * j); }
    double rigid() const { return body_.tables().rigid_stiffness_n_per_m; }
    Place& interpolated(int patch, const Vector3d& alpha, Place& to) const {
        Matrix3d s[3], sum = Matrix3d::Zero();
        for (int c = 0; c < 3; ++c) {
            const auto v = Eigen::Index(body_.vertex(patch, c));
            s[c] = body_.is_free(body_.vertex(patch, c)) ? Matrix3d(l(v, v).inverse())
                                                         : Matrix3d(rigid() * Matrix3d::Identity());
            sum += alpha[c] * s[c];
        }
        to.own = sum.inverse();
        for (int c = 0; c < 3; ++c)
            if (body_.is_free(body_.vertex(patch, c)))
                to.share.middleRows<3>(3 * Eigen::Index(body_.vertex(patch, c))) = alpha[c] * s[c] * to.own;
        return to;
    }
    void lift(int patch, const Vector3d& alpha, Matrix3d& own) const {
        double fixed = 0.0;
        for (int c = 0; c < 3; ++c)
            if (!body_.is_free(body_.vertex(patch, c))) fixed += alpha[c];
        const double missing = fixed / rigid() - own.trace() / 3.0;
        if (fixed > 0.0 && missing > 0.0) own += missing * Matrix3d::Identity();
    }

    const ElasticBody& body_;
    ForceLaw force_;
};

Vector3d alpha_of(const haptable_output& out) { return to_vector(out.alpha); }

struct Errors {
    double worst = 0.0, condition = 0.0;
    int both = 0, alone = 0, meeting = 0;
};

/// Forces at random pairs of places against direct solves, by what the condition allows.
Errors compare_forces(const ElasticBody& body, ForceLaw force, int pairs) {
    Pair pair(body, GodObject::kNearest);
    const Direct direct(body, force);
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
        const auto a = direct.place(pair.out[0].patch, alpha_of(pair.out[0]));
        const auto b = direct.place(pair.out[1].patch, alpha_of(pair.out[1]));
        if (!(a.own.trace() > 0.0 && b.own.trace() > 0.0)) continue;
        Vector6d felt, u, wanted = Vector6d::Zero();
        felt << pair.force(0), pair.force(1);
        u << pair.u(0), pair.u(1);
        const Matrix6d c = direct.compliance(a, b, meeting_m);
        const Eigen::VectorXd value = dense::eigenvalues(c);
        // Two places that load one node alone: C is singular, and the servo lifts it (see below).
        if (!(value[0] > 1e-12 * value[5])) continue;
        const double condition = value[5] / value[0];
        if (pair.touches(0) && pair.touches(1)) {
            wanted = -dense::solve(c, u);
            ++errors.both;
        } else {
            const int one = pair.touches(0) ? 0 : 1;
            wanted.segment<3>(3 * one) = -(one == 0 ? a : b).own.inverse() * u.segment<3>(3 * one);
            ++errors.alone;
        }
        errors.meeting += (a.at - b.at).norm() < meeting_m ? 1 : 0;
        const double error = (felt - wanted).norm() / wanted.norm();
        errors.worst = std::max(errors.worst, error);
        errors.condition = std::max(errors.condition, condition);
        // The rounding of a 6x6 by blocks of rounded numbers, and the place's own over the depth.
        const Bound bound{.count = 32,
                          .epsilon = kFloat,
                          .condition = condition + body.size() / pair.u(0).norm() + body.size() / pair.u(1).norm()};
        if (pair.model().place_count > 0) continue;  // not all pairs
        EXPECT_WITHIN(error, bound) << force << " " << errors.both;
    }
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
        const ElasticBody body(for_two(cube_scene(5, 0.3)), force, 0.01);
        const Errors errors = compare_forces(body, force, random_pairs(10000));
        RecordProperty(std::string("worst, ") + word(force), std::to_string(1e6 * errors.worst) + "e-6");
        EXPECT_LT(errors.worst, 1e-5) << force;
        EXPECT_GT(errors.both, 2000);
        EXPECT_GT(errors.meeting, 0);
    }
}

TEST(Pair, ForcesAreThoseOfDirectSolvesOnTheMouse) {
    const int pairs = random_pairs(1000);
    for (const ForceLaw force : kForces) {
        if (force != ForceLaw::kInterpolated && pairs <= 1000) continue;
        const ElasticBody body(for_two(mouse_scene(true)), force, 0.004);
        const Errors errors = compare_forces(body, force, pairs);
        RecordProperty(std::string("worst, ") + word(force), std::to_string(1e6 * errors.worst) + "e-6");
        EXPECT_LT(errors.worst, 1e-5) << force;
        EXPECT_GT(errors.both, 700);
    }
}

/// Two vertices of an edge between free ones.
std::pair<int, Vector3d> edge_of_top(const ElasticBody& body, Vector3d& other) {
    Vector3d alpha;
    const int patch = body.patch_over(0.0151, 0.0141, alpha);
    alpha = Vector3d(1, 0, 0);
    other = Vector3d(0, 1, 0);
    return {patch, alpha};
}

TEST(Pair, TwoNeighbouringNodesAreThePapersThreeNByThreeN) {
    const ElasticBody body(for_two(cube_scene(5, 0.3)), ForceLaw::kInterpolated);
    Pair pair(body, GodObject::kNearest);
    Vector3d other;
    const auto [patch, alpha] = edge_of_top(body, other);
    const Vector3d down(0, 0, -0.001);
    pair.put(0, patch, alpha, body.point(patch, alpha) + down);
    pair.put(1, patch, other, body.point(patch, other) + down);
    pair.to(body.point(patch, alpha) + down, body.point(patch, other) + down);
    ASSERT_TRUE(pair.touches(0) && pair.touches(1));
    const auto i = Eigen::Index(body.vertex(patch, 0)), j = Eigen::Index(body.vertex(patch, 1));
    const Eigen::MatrixXd& l = body.compliance();
    Matrix6d two;
    two << l.block<3, 3>(3 * i, 3 * i), l.block<3, 3>(3 * i, 3 * j), l.block<3, 3>(3 * j, 3 * i),
        l.block<3, 3>(3 * j, 3 * j);
    Vector6d u, felt, single;
    u << pair.u(0), pair.u(1);
    felt << pair.force(0), pair.force(1);
    single << two.block<3, 3>(0, 0).inverse() * u.head<3>(), two.block<3, 3>(3, 3).inverse() * u.tail<3>();
    const Vector6d wanted = dense::solve(two, u);
    EXPECT_WITHIN((felt + wanted).norm(), .count = 64, .epsilon = kFloat, .condition = 16, .size = wanted.norm());
    const double stiffer = (single[2] + single[5]) / (wanted[2] + wanted[5]) - 1.0;
    EXPECT_GT(stiffer, 0.2);  // what equation 7 alone makes of them
}

/// Of some 2 mm of a dent 2.5 times as stiff, with a tangent of 6.
constexpr StiffeningCurve kStiff{{0.5, -0.5, 1.5}, 5e-5};

void expect_the_servo_of_one(const StiffeningCurve& curve) {
    const ElasticBody body(for_two(cube_scene(5, 0.3)), ForceLaw::kConsistent);
    Pair pair(body, GodObject::kLeastEnergy, 0.0, false, curve);
    haptable_servo servo;
    haptable_servo_init(&servo);
    const double steepest = curve.largest_tangent(1.0);
    const haptable_model& model = *pair.model().model;
    for (int tick = 0; tick < 400; ++tick) {
        const float x[3] = {0.012F + 1e-5F * float(tick), 0.014F, 0.031F - 1e-5F * float(tick)};
        haptable_output out{};
        haptable_servo_step(&model, &servo, x, std::uint32_t(tick + 1) * HAPTABLE_TICK_US, &out);
        pair.to(Vector3d(double(x[0]), double(x[1]), double(x[2])), Vector3d(0.1, 0.1, 0.1));
        ASSERT_EQ(out.state, pair.out[0].state) << tick;
        EXPECT_WITHIN((to_vector(out.god_object_m) - to_vector(pair.out[0].god_object_m)).norm(), .size = 0.0);
        // Least energy gives the load to first order between evaluations, LOAD_CORRECTION squared; and the position's
        // own rounding over the depth.
        const double depth_m = std::max(1e-7, pair.u(0).norm()), first_order = 6.25e-6;
        EXPECT_WITHIN((to_vector(out.force_n) - pair.force(0)).norm(), .count = 16,
                      .epsilon = steepest * (first_order + kFloat * body.size() / depth_m),
                      .size = to_vector(out.force_n).norm());
    }
}

TEST(Pair, OneFingerIsTheServo) {
    expect_the_servo_of_one({});
    expect_the_servo_of_one(kStiff);
}

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
            const ElasticBody body(for_two(cube_scene(5, 0.3)), force, 0.01);
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

// The fingers change places, and what the body remembers of them.
TEST(Pair, FingersOfDentsThatStiffenMayChangePlaces) {
    const ElasticBody body(for_two(cube_scene(5, 0.3)), ForceLaw::kPressureMask, 0.01);
    for (const GodObject god_object : every<GodObject>()) {
        Pair one(body, god_object, 0.0, false, kStiff), two(body, god_object, 0.0, false, kStiff);
        for (int i = 0; i < 300; ++i) {
            const Vector3d x(0.0131 + 1e-5 * i, 0.0142, 0.0301 - 1e-5 * std::min(i, 200)),
                y(0.0212, 0.0163 - 1e-5 * i, 0.0301 - 1.5e-5 * std::min(i, 150));
            one.to(x, y);
            two.to(y, x);
            const double size = one.force(0).norm() + one.force(1).norm();
            // Where both rest within a tick's correction of each other.
            for (int f = 0; f < 2; ++f)
                EXPECT_WITHIN((one.force(f) - two.force(1 - f)).norm(), .epsilon = 3e-3, .size = size) << i;
        }
    }
}

/// What a finger is told of another one at a place.
haptable_pair_view told_of(const Pair& pair, const ElasticBody& body, int patch, const Vector3d& beta,
                           const Vector3d& y) {
    haptable_pair_view view = pair.state().view[0];
    const haptable_contact contact = contact_at(body, patch, beta);
    const float finger_m[3] = {float(y[0]), float(y[1]), float(y[2])};
    const bool is_mask = pair.model().law->controls == HAPTABLE_PAIR_CONTROLS;
    haptable_pair_own own{};
    pair.model().law->own(pair.model().model, &contact, finger_m, &own);
    const double c[9] = {own.a[0], own.a[3], own.a[5], own.a[3], own.a[1], own.a[4], own.a[5], own.a[4], own.a[2]};
    const Matrix3d m = Eigen::Map<const Matrix3d>(c).inverse();
    const double packed[6] = {m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(1, 2), m(2, 0)};
    for (int k = 0; k < 6; ++k) view.m[k] = float(packed[k]);
    for (int k = 0; k < 3; ++k) {
        view.place.weight[k] = float(is_mask ? beta[k] * beta[k] : beta[k]);
        if (is_mask) view.place.weight[3 + k] = float(2.0 * beta[(k + 1) % 3] * beta[(k + 2) % 3]);
        view.s[k] = own.s[k];
        view.at_m[k] = contact.god_object_m[k];
    }
    for (int k = 0; k < 3; ++k) view.alone[k] = float((m * to_vector(own.s))[k]);
    view.is_coupled = 1;
    for (haptable_pair_rows& rows : view.rows) rows.patch = HAPTABLE_NONE;
    return view;
}

std::vector<std::pair<ForceLaw, StiffeningCurve>> with_and_without_stiffening() {
    std::vector<std::pair<ForceLaw, StiffeningCurve>> all;
    for (const ForceLaw force : kForces)
        for (const StiffeningCurve& curve : {StiffeningCurve{}, kStiff}) all.emplace_back(force, curve);
    return all;
}

TEST(Pair, SlopeAndCurvatureAreTheEnergysDerivatives) {
    for (const auto& [force, curve] : with_and_without_stiffening()) {
        const ElasticBody body(for_two(cube_scene(5, 0.3)), force, 0.01);
        Pair pair(body, GodObject::kLeastEnergy, 0.0, false, curve);
        std::mt19937 random(3);
        std::uniform_int_distribution<int> any(0, body.patches() - 1);
        double worst_slope = 0.0, worst_bend = 0.0;
        int judged = 0;
        for (int i = 0; i < 200; ++i) {
            const int p = any(random), q = i % 4 == 0 ? p : any(random);
            const Vector3d alpha = (random_alpha(random) + Vector3d::Ones()) / 4.0, beta = random_alpha(random);
            const Vector3d x = body.point(p, alpha) - 0.002 * body.normal(p) + 3e-4 * random_alpha(random);
            const Vector3d y = body.point(q, beta) - 0.001 * body.normal(q);
            pair.begin();
            pair.put(0, p, alpha, x);
            pair.put(1, q, beta, y);
            pair.to(x, y);
            // Where they nearly meet a step of h is too long for differences.
            const double apart = (body.point(p, alpha) - body.point(q, beta)).norm();
            if (!pair.touches(0) || !pair.touches(1) || apart < 0.5 * double(pair.model().meeting_m)) continue;
            ++judged;
            const haptable_pair_view view = told_of(pair, body, q, beta, y);
            const auto at = [&](double b, double c) {
                const haptable_contact contact = contact_at(body, p, alpha + Vector3d(-b - c, b, c));
                const float finger_m[3] = {float(x[0]), float(x[1]), float(x[2])};
                haptable_energy e{};
                pair.model().energy(&view.model, &contact, finger_m, HAPTABLE_ENERGY_ALL, &e);
                return e;
            };
            const haptable_energy e = at(0, 0);
            // What the finger alone would store: of what the other leaves, little may be left.
            const haptable_contact here = contact_at(body, p, alpha);
            const float here_m[3] = {float(x[0]), float(x[1]), float(x[2])};
            haptable_energy alone{};
            pair.model().model->energy(pair.model().model, &here, here_m, HAPTABLE_ENERGY_ALL, &alone);
            const double h = 0.02, size = double(alone.energy_j);
            // Differences over h and half of it: what is of second order in h cancels.
            const auto derivative = [&](double db, double dc, const auto& of) {
                const auto over = [&](double step) {
                    return (of(at(step * db, step * dc)) - of(at(-step * db, -step * dc))) / (2 * step);
                };
                return (4.0 * over(h / 2) - over(h)) / 3.0;
            };
            for (int b = 0; b < 2; ++b) {
                const double db = b == 0 ? 1 : 0, dc = b == 1 ? 1 : 0;
                const double slope = derivative(db, dc, [](const haptable_energy& of) { return double(of.energy_j); });
                const double bend =
                    derivative(db, dc, [b](const haptable_energy& of) { return double(of.gradient_j[b]); });
                worst_slope =
                    std::max(worst_slope, std::abs(slope - double(e.gradient_j[b])) / (std::abs(slope) + size));
                worst_bend = std::max(worst_bend,
                                      std::abs(bend - double(e.hessian_j[b == 0 ? 0 : 2])) / (std::abs(bend) + size));
                for (int c = 0; c < 3; ++c) {
                    const double load =
                        derivative(db, dc, [c](const haptable_energy& of) { return double(of.load_n[c]); });
                    EXPECT_WITHIN(std::abs(load - double(e.load_gradient_n[b][c])) /
                                      (std::abs(load) + to_vector(e.load_n).norm()),
                                  .count = 100, .epsilon = h * h);
                }
            }
            const double cross = derivative(0, 1, [](const haptable_energy& of) { return double(of.gradient_j[0]); });
            worst_bend = std::max(worst_bend, std::abs(cross - double(e.hessian_j[1])) / (std::abs(cross) + size));
        }
        EXPECT_GT(judged, 100);
        // An error of fourth order in h over patches of 4 times u, and roundings over h.
        EXPECT_WITHIN(worst_slope, .count = 100, .epsilon = 4e-4) << force;
        EXPECT_WITHIN(worst_bend, .count = 250, .epsilon = 4e-4) << force;
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
        double given = 0.0, stored = 0.0;
        bool both = true;
        Vector3d last[2] = {x[0], x[1]}, force[2] = {Vector3d::Zero(), Vector3d::Zero()};
        const auto at = [&](int finger, double t, double depth) {
            const double a = 2 * M_PI * t;
            return Vector3d(x[finger] - depth * deep[finger] * n[finger] +
                            (std::cos(a + phase[finger]) - std::cos(phase[finger])) * along[finger] +
                            std::sin(a) * beside[finger]);
        };
        const auto go = [&](const Vector3d& a, const Vector3d& b) {
            pair.to(a, b);
            for (int finger = 0; finger < 2; ++finger) {
                given += 0.5 * (pair.force(finger) + force[finger]).dot(pair.at[finger] - last[finger]);
                last[finger] = pair.at[finger];
                force[finger] = pair.force(finger);
            }
            stored = std::max(stored, pair.energy());
            both = both && pair.touches(0) && pair.touches(1);
            const int by_one = pair.state().is_following;
            result.followed += by_one > 0;
            result.reused += by_one > 1;
            result.most = std::max(result.most, by_one);
        };
        pair.to(x[0], x[1]);
        for (int i = 1; i <= ticks / 4; ++i) go(at(0, 0, 4.0 * i / ticks), at(1, 0, 4.0 * i / ticks));
        // Where both god-objects have come to rest, around, and to rest again.
        for (int i = 0; i < 50; ++i) go(at(0, 0, 1), at(1, 0, 1));
        const double before = pair.energy();
        given = 0.0;
        both = true;
        for (int i = 1; i <= ticks; ++i) go(at(0, double(i) / ticks, 1), at(1, double(i) / ticks, 1));
        for (int i = 0; i < 50; ++i) go(at(0, 1, 1), at(1, 1, 1));
        if (stored < 1e-7 || !both) continue;
        given += pair.energy() - before;  // what is left there may be another minimum's
        ++result.loops;
        result.worst = std::max(result.worst, given / stored);
    }
    return result;
}

TEST(Pair, ClosedLoopsOfBothGiveNoEnergy) {
    for (const ForceLaw force : kForces) {
        const ElasticBody body(for_two(cube_scene(5, 0.3)), force, 0.01);
        EXPECT_LT(run_loops(body, 12, 0.003, 0.004, 12800).worst, 1e-3) << force;
        EXPECT_LT(run_loops(body, 12, 0.003, 0.004, 12800, kStiff).worst, 1e-3) << force << " stiffens";
    }
}

// 500 ticks around an ellipse of at most 25 mm: a hand's speed. Both god-objects of a tick rest together.
TEST(Pair, ClosedLoopsOfBothGiveNoEnergyAtAHandsSpeed) {
    for (const ForceLaw force : kForces) {
        const ElasticBody body(for_two(cube_scene(5, 0.3)), force, 0.01);
        const PairLoops loops = run_loops(body, 24, 0.003, 0.004, 500);
        EXPECT_LT(loops.worst, 1e-3) << force;
        const PairLoops stiff = run_loops(body, 24, 0.003, 0.004, 500, kStiff);
        EXPECT_LT(stiff.worst, 1e-3) << force << " stiffens";
        EXPECT_GT(stiff.followed, loops.followed / 2) << force;
        EXPECT_GT(loops.reused, loops.followed / 2) << force;
        EXPECT_LE(loops.most, HAPTABLE_PAIR_REUSED) << force;
    }
}

/// Both slide 1 mm deep over several patches of a cube's top, 50 um a tick. Of the ticks with both in contact, the part
/// in which neither took more than so many steps of the energy by itself.
double followed_part(ForceLaw force, double friction, unsigned most) {
    const ElasticBody body(for_two(cube_scene(5, 0.3)), force, 0.01);
    Pair pair(body, GodObject::kLeastEnergy, friction);
    int ticks = 0, followed = 0;
    for (int i = 0; i < 400; ++i) {
        const double deep = std::min(1e-3, 2e-5 * i), along = 5e-5 * std::max(0, i - 50);
        for (haptable_servo& servo : pair.state().servo) servo.counters.most_energies = 0;
        pair.to({0.0061 + along, 0.0082 + 0.3 * along, 0.0301 - deep},
                {0.0242 - along, 0.0213 - 0.2 * along, 0.0301 - deep});
        if (!pair.touches(0) || !pair.touches(1)) continue;
        ++ticks;
        followed += std::ranges::all_of(pair.state().servo,
                                        [most](const auto& servo) { return servo.counters.most_energies <= most; });
    }
    EXPECT_GT(ticks, 300);
    return double(followed) / ticks;
}

TEST(Pair, BothAreFollowedOverEdges) {
    for (const ForceLaw force : kForces) EXPECT_GT(followed_part(force, 0.0, 0), 0.99) << force;
}

// An evaluation where the minimum is foreseen, and one more for the load or over an edge; a descent takes more.
TEST(Pair, WithFrictionEachIsFollowedToo) {
    for (const ForceLaw force : kForces) EXPECT_GT(followed_part(force, 0.3, 2 * STEPS_OF_ENERGY), 0.8) << force;
}

// The second comes in where the first's dent is deep: no energy is asked for where it would meet the surface.
TEST(Pair, AFingerFarBehindIsAtTheNearestPoint) {
    const ElasticBody body(for_two(cube_scene(5, 0.3)), ForceLaw::kConsistent);
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
    const ElasticBody body(for_two(cube_scene(5, 0.3)), ForceLaw::kConsistent);
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

TEST(Pair, FingersThatMeetStayWellPosed) {
    for (const ForceLaw force : kForces) {
        const ElasticBody body(for_two(cube_scene(5, 0.3)), force, 0.01);
        Pair pair(body, GodObject::kNearest);
        Vector3d alpha;
        const int patch = body.patch_over(0.0161, 0.0131, alpha);
        const Vector3d start = body.point(patch, alpha), along(0.6, 0.8, 0.0);
        const auto meeting_m = double(pair.model().meeting_m);
        Vector3d last = Vector3d::Zero(), alone = Vector3d::Zero();
        double steepest = 0.0;
        // From beyond the meeting distance through the other finger, which is pressed half as deep.
        const int steps = 800;
        for (int i = 0; i <= steps; ++i) {
            const double apart = meeting_m * 1.5 * (2.0 * i / steps - 1.0);
            pair.begin();
            const Vector3d g = start + apart * along;
            Vector3d at;
            const int here = body.patch_over(g.x(), g.y(), at);
            pair.put(0, here, at, g - Vector3d(0, 0, 1e-3));
            pair.put(1, patch, alpha, start - Vector3d(0, 0, 0.9e-3));
            pair.to(g - Vector3d(0, 0, 1e-3), start - Vector3d(0, 0, 0.9e-3));
            ASSERT_TRUE(pair.force(0).allFinite());
            if (i == 0) alone = pair.force(0);
            if (i > 0) steepest = std::max(steepest, (pair.force(0) - last).norm());
            last = pair.force(0);
            // With an eighth of the coupling gone, C is at least an eighth of that of a finger alone.
            EXPECT_LT(pair.force(0).norm(), 8.0 * 2.0 * alone.norm()) << force;
        }
        // No step of these is a jump: each is a small part of the force.
        EXPECT_LT(steepest, 0.05 * alone.norm()) << force;
    }
}

TEST(Pair, AFingerIsFeltByTheOther) {
    const ElasticBody body(for_two(cube_scene(5, 0.3)), ForceLaw::kConsistent);
    Pair pair(body, GodObject::kNearest);
    const Vector3d first(0.0101, 0.0152, 0.0301), second(0.0201, 0.0152, 0.0301);
    Vector3d before = Vector3d::Zero();
    for (int i = 0; i <= 200; ++i) {
        pair.to(first - Vector3d(0, 0, 2e-5 * std::max(0, i - 100)), second - Vector3d(0, 0, 1e-5 * std::min(i, 100)));
        if (i == 100) before = pair.force(1);
    }
    // The dent of the first takes the surface away under the second, which has not moved.
    EXPECT_LT(pair.force(1).z(), 0.98 * before.z());
    EXPECT_TRUE(pair.touches(1));
}

// By the servo's own numbers, beside direct solves; 1 % is what a compressed coupling may be off.
TEST(Pair, ForcesOfClustersAreWithinAHundredthOfDirectSolves) {
    constexpr std::pair<ForceLaw, std::uintmax_t> kBytes[] = {
        {ForceLaw::kInterpolated, 40'000}, {ForceLaw::kConsistent, 50'000}, {ForceLaw::kPressureMask, 70'000}};
    for (const auto& [force, bytes] : kBytes) {
        const ElasticBody body(for_two(cube_scene(5, 0.3), bytes), force, 0.01);
        const PairTables few = body.pair();
        ASSERT_FALSE(few.is_exact());
        EXPECT_EQ(few.clusters.load_begin.empty(), force != ForceLaw::kPressureMask);
        EXPECT_LE(pair_bytes(few), bytes);
        const Errors errors = compare_forces(body, force, random_pairs(1000));
        RecordProperty(std::string("worst, ") + word(force), std::to_string(1e3 * errors.worst) + "e-3");
        EXPECT_GT(errors.worst, 1e-5) << force;
        EXPECT_LT(errors.worst, 1e-2) << force;
        EXPECT_GT(errors.both, 200);
    }
}

// Where a patch of masks loads more nodes than the servo has room for, their controls are in clusters.
TEST(Pair, MasksThatAreWideHaveTheirControlsInClusters) {
    const ElasticBody body(for_two(cube_scene(5, 0.3), 1'200'000), ForceLaw::kPressureMask, 0.03);
    const PairTables few = body.pair();
    ASSERT_FALSE(few.is_exact());
    EXPECT_TRUE(few.clusters.load_begin.empty());
    EXPECT_EQ(few.clusters.places(), few.control_count);
    EXPECT_LE(pair_bytes(few), 1'200'000U);
    const Errors errors = compare_forces(body, ForceLaw::kPressureMask, 20);
    EXPECT_LT(errors.worst, 1e-2);
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
            both += pair.touches(0) && pair.touches(1) ? 1 : 0;
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

/// Both down into the top, along it, and out again.
std::string two_strokes() {
    std::string text = "x,y,z,x2,y2,z2\n";
    for (int i = 0; i < 300; ++i) {
        const double s = i / 300.0, depth_m = 0.003 * std::sin(M_PI * s) - 0.001;
        text += std::to_string(0.006 + 0.007 * s) + ",0.0131," + std::to_string(0.03 - depth_m) + "," +
                std::to_string(0.024 - 0.007 * s) + ",0.0171," + std::to_string(0.03 - 0.5 * depth_m) + "\n";
    }
    return text;
}

TEST(Pair, AReplayOfTwoGivesWhatTheServoGivesAndIsAPathAgain) {
    const ElasticBody body(for_two(cube_scene(5, 0.3)), ForceLaw::kConsistent);
    Pair pair(body, GodObject::kLeastEnergy);
    const TemporaryFolder folder;
    const auto in = folder.path() / "in.csv", out = folder.path() / "out.csv", again = folder.path() / "again.csv";
    std::vector<std::uint32_t> node(body.servo().node.begin(), body.servo().node.end());
    const ServoScene scene{pair.model().model, node.data(), "cube", &pair.model()};
    write_file(in, two_strokes());
    const ReplayReport report = replay(scene, in, out, true);
    ASSERT_EQ(report.others.size(), 1U);
    double largest[2] = {0.0, 0.0};
    for (const FingerTick& tick : read_finger_ticks(in, Positions::finite)) {
        pair.to(Eigen::Map<const Vector3d>(tick.position_m.data()),
                Eigen::Map<const Vector3d>(tick.others[0].position_m.data()));
        for (int finger = 0; finger < 2; ++finger)
            largest[finger] = std::max(largest[finger], pair.force(finger).norm());
    }
    EXPECT_GT(largest[1], 0.01);
    EXPECT_WITHIN(std::abs(report.largest_force_n - largest[0]), .count = 4, .size = largest[0]);  // squares and a root
    EXPECT_WITHIN(std::abs(report.others[0].largest_force_n - largest[1]), .count = 4, .size = largest[1]);
    EXPECT_EQ(report.others[0].counters.contact_ticks, pair.state().servo[1].counters.contact_ticks);
    replay(scene, out, again, true);
    EXPECT_EQ(read_file(again), read_file(out));
    const ServoScene alone{pair.model().model, node.data(), "cube"};
    EXPECT_NE(error_of([&] { replay(alone, in, again, true); }).find("fingers = 2"), std::string::npos);
}

TEST(Pair, PathsAndScenesOfTwoAreRefusedWithTheirLine) {
    const TemporaryFolder folder;
    const auto file = folder.path() / "path.csv", scene = folder.path() / "scene.toml";
    const auto path_error = [&](const std::string& text) {
        write_file(file, text);
        return error_of([&] { read_finger_ticks(file, Positions::finite); });
    };
    EXPECT_EQ(path_error("x,y,z,x2,y2,z2\n0,0,0,1,1,1\n"), "no error");
    EXPECT_NE(path_error("x,y,z,x2,y2,z2\n0,0,0,1,1\n").find(":2: "), std::string::npos);
    EXPECT_NE(path_error("x,y,z,x2,y2,z2\n0,0,0,1,nan,1\n").find(":2: "), std::string::npos);
    EXPECT_NE(path_error("x,y,z,x2\n").find("x,y,z,x2,y2,z2"), std::string::npos);
    const std::string good =
        "name = \"a\"\n[mesh]\ngenerate = \"cube\"\n[material]\nyoung = 1e4\npoisson = 0.3\n[[fixed]]\n"
        "box = [-1, -1, -1, 1, 1, 1e-9]\n";  // 8 lines
    const auto scene_error = [&](const std::string& more) {
        write_file(scene, good + more);
        return error_of([&] { read_scene(scene); });
    };
    EXPECT_EQ(scene_error("[contact]\nfingers = 2\n[tables]\ncoupling_bytes = 1000\n"), "no error");
    EXPECT_NE(scene_error("[contact]\nfingers = 3\n").find(":10: contact.fingers"), std::string::npos);
    EXPECT_NE(scene_error("[tables]\ncoupling_bytes = 1000\n").find(":10: tables.coupling_bytes"), std::string::npos);
    EXPECT_NE(scene_error("[contact]\nfingers = 2\n[tables]\ncoupling_bytes = 0\n").find(":12: "), std::string::npos);
    EXPECT_EQ(scene_error("[contact]\nfingers = 2\nforce = \"consistent\"\n[tables]\nprecision = \"int16\"\n"),
              "no error");
    EXPECT_EQ(scene_error("[contact]\nfingers = 2\n[[relaxation]]\nshare = 0.3\ntime = 1.0\n"), "no error");
}

TEST(Pair, TheCheckOfTheTablesCoversTheCoupling) {
    const ElasticBody body(for_two(cube_scene(5, 0.3), 50'000), ForceLaw::kConsistent);
    Tables tables = body.tables();
    tables.limits = {};
    tables.limits.check = true;
    ServoPair coupling = build_pair(body.pair(), tables, body.servo());
    const haptable_model model = model_in_memory(tables, body.servo());
    const haptable_pair_model whole = pair_in_memory(coupling, tables, model);
    Vector3d alpha;
    const int patch = body.patch_over(0.0151, 0.0141, alpha);
    const Vector3d x = body.point(patch, alpha);
    const float out_m[3] = {float(x[0]), float(x[1]), float(x[2] + 1e-3)};
    const float in_m[3] = {float(x[0]), float(x[1]), float(x[2] - 1e-3)};
    for (const bool damaged : {false, true}) {
        if (damaged) coupling.clusters.core[coupling.clusters.core.size() / 2] ^= 4;
        haptable_room room{};
        haptable_pair& pair = room.fingers;
        haptable_pair_init(&whole, &pair);
        haptable_output out[2];
        haptable_pair_step(&whole, &pair, out_m, out_m, 1000, out);
        EXPECT_EQ(out[0].state, HAPTABLE_FAULTED);  // nobody looked at them
        haptable_scene scene;
        haptable_scene_make(&model, &whole, nullptr, nullptr, &scene);
        haptable_check(&scene, &pair, HAPTABLE_CHECK_ALL);
        haptable_pair_step(&whole, &pair, out_m, out_m, 2000, out);
        haptable_pair_step(&whole, &pair, in_m, in_m, 3000, out);
        for (const haptable_output& one : out) {
            EXPECT_EQ(one.state, damaged ? HAPTABLE_FAULTED : HAPTABLE_CONTACT);
            EXPECT_EQ(one.faults, damaged ? HAPTABLE_FAULT_TABLES : 0);
            EXPECT_EQ(to_vector(one.force_n).norm() > 0.0, !damaged);
        }
    }
}

TEST(Pair, PassivityObservesBothHandsTogether) {
    const ElasticBody body(for_two(cube_scene(5, 0.3)), ForceLaw::kConsistent);
    Pair pair(body, GodObject::kNearest, 0.0, true);
    // In, aside at that depth, out, and back over the surface: there the nearest god-object gives energy
    // (docs/CONTACT.md).
    double given = 0.0, most = 0.0;
    Vector3d last[2];
    for (int i = 0; i < 4 * 800; ++i) {
        const int phase = i / 200 % 4;
        const double s = i % 200 / 200.0;
        const double depth = 4.1e-3 * (phase == 0 ? s : phase == 1 ? 1.0 : phase == 2 ? 1.0 - s : 0.0) - 1e-4;
        const double aside = phase == 1 ? s : phase == 2 ? 1.0 : phase == 3 ? 1.0 - s : 0.0;
        const Vector3d x(0.015 + 5e-3 * aside, 0.015 + 6e-3 * aside, 0.03 - depth);
        const Vector3d y(0.010 - 5e-3 * aside, 0.010 - 6e-3 * aside, 0.03 - 0.7 * depth);
        const Vector3d held[2] = {pair.force(0), pair.force(1)};
        pair.to(x, y);
        for (int finger = 0; finger < 2 && i > 0; ++finger) given += held[finger].dot(pair.at[finger] - last[finger]);
        for (int finger = 0; finger < 2; ++finger) last[finger] = pair.at[finger];
        most = std::max(most, given);
    }
    // What a tick gave beyond is braked away in the next one: at most a tick's force over a tick's way.
    EXPECT_LE(most, 2.0 * 0.5 * 4e-5);
}

TEST(Pair, TwoPlacesThatLoadOneNodeAloneStayWellPosed) {
    const ElasticBody body(for_two(cube_scene(5, 0.3)), ForceLaw::kConsistent);
    const Pair pair(body, GodObject::kLeastEnergy);
    int places = 0;
    for (int p = 0; p < body.patches(); ++p) {
        int free = -1, count = 0;
        for (int c = 0; c < 3; ++c)
            if (body.is_free(body.vertex(p, c))) free = c, ++count;
        if (count != 1) continue;
        Vector3d alpha = Vector3d::Constant(0.3), beta = Vector3d::Constant(1.5e-4);
        alpha[free] = 0.4;
        beta[free] = 0.9997;
        const Vector3d x = body.point(p, alpha) - 1e-3 * body.normal(p),
                       y = body.point(p, beta) + 1e-3 * Vector3d::UnitX();
        const haptable_pair_view view = told_of(pair, body, p, beta, y);
        const haptable_contact contact = contact_at(body, p, alpha);
        const float finger_m[3] = {float(x[0]), float(x[1]), float(x[2])};
        haptable_energy alone{}, both{};
        haptable_energy_consistent(pair.model().model, &contact, finger_m, HAPTABLE_ENERGY_ALL, &alone);
        pair.model().energy(&view.model, &contact, finger_m, HAPTABLE_ENERGY_ALL, &both);
        // A 64th of C_11 is left, and the other's displacement is as large.
        EXPECT_LT(to_vector(both.load_n).norm(), 64.0 * 8.0 * to_vector(alone.load_n).norm()) << p;
        ++places;
    }
    EXPECT_GT(places, 10);
}

}  // namespace
}  // namespace haptable::test
