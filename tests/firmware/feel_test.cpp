// SPDX-License-Identifier: GPL-2.0-or-later
// What a finger notices: contact that is never lost, no click and no buzz, and the digits of a float.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "firmware/haptable_bounds.h"
#include "tests/bodies.hpp"
#include "tests/finger.hpp"
#include "tests/reference_servo.hpp"
#include "tests/shapes.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;

/// A shape and how deep a point lies in it at the least, m; negative outside.
struct Solid {
    Shape shape;
    std::function<double(const Vector3d&)> depth;
};

double box_depth(const Vector3d& x, const Vector3d& low, const Vector3d& high) {
    return std::min((x - low).minCoeff(), (high - x).minCoeff());
}

Shape moved(Shape shape, const std::function<Vector3d(const Vector3d&)>& to) {
    for (auto& x : shape.point) x = to(x);
    return shape;
}

/// A box of which the upper side is narrowed to `least` of its width in x, and in y where `both`.
Solid tapered(const std::string& name, int cells, const Vector3d& side, double least, bool both) {
    const auto width = [=](double z) { return 1.0 - (1.0 - least) * z / side.z(); };
    Shape shape = moved(box_shape(cells, side), [=](const Vector3d& x) {
        const double w = width(x.z());
        return Vector3d((x.x() - 0.5 * side.x()) * w, (x.y() - 0.5 * side.y()) * (both ? w : 1.0), x.z());
    });
    shape.name = name;
    return {shape, [=](const Vector3d& x) {
                if (x.z() < 0.0 || x.z() > side.z()) return -1.0;
                const double w = width(x.z());
                const double slope = std::hypot(1.0, 0.5 * side.x() * (1.0 - least) / side.z());
                return std::min({x.z(), side.z() - x.z(), (0.5 * side.x() * w - std::abs(x.x())) / slope,
                                 (0.5 * side.y() * (both ? w : 1.0) - std::abs(x.y())) / slope});
            }};
}

/// A convex shape, by the planes of its patches.
Solid convex(const Shape& shape) {
    std::vector<std::pair<Vector3d, double>> plane;
    for (const auto& [a, b, c] : shape.patch) {
        const auto at = [&](std::int32_t i) { return shape.point[std::size_t(i)]; };
        const Vector3d n = (at(b) - at(a)).cross(at(c) - at(a)).normalized();
        plane.emplace_back(n, n.dot(at(a)));
    }
    return {shape, [plane](const Vector3d& x) {
                double depth = 1.0;
                for (const auto& [n, d] : plane) depth = std::min(depth, d - n.dot(x));
                return depth;
            }};
}

/// Where cavities, hinges and vertices of few and of many patches are.
std::vector<Solid> odd_solids() {
    const Vector3d o = Vector3d::Zero(), side(0.04, 0.04, 0.04), hollow(0.01, 0.01, 0.01);
    std::vector<Solid> all;
    all.push_back({hollow_shape(4, 0.04), [=](const Vector3d& x) {
                       return std::min(box_depth(x, o, side), -box_depth(x, hollow, side - hollow));
                   }});
    all.push_back({hinge_shape(4, 0.04), [=](const Vector3d& x) {  // both arms share the edge x = z = 0.02
                       return std::max(box_depth(x, o, Vector3d(0.02, 0.04, 0.02)),
                                       box_depth(x, Vector3d(0.02, 0, 0.02), side));
                   }});
    all.push_back(convex(spindle_shape(3, 0.02, 0.03)));
    all.push_back(convex(spindle_shape(30, 0.02, 0.03)));
    all.push_back(convex(fanned_disk_shape(28, 0.03, 0.01)));
    return all;
}

std::vector<Solid> solids() {
    const Vector3d cube(0.03, 0.03, 0.03), plate(0.1, 0.1, 0.001);
    std::vector<Solid> all;
    all.push_back({box_shape(4, cube), [=](const Vector3d& x) { return box_depth(x, Vector3d::Zero(), cube); }});
    all.push_back({box_shape(10, plate), [=](const Vector3d& x) { return box_depth(x, Vector3d::Zero(), plate); }});
    all.back().shape.name = "thin plate";
    all.push_back({sphere_shape(3, 0.03), [](const Vector3d& x) { return 0.03 * 0.985 - x.norm(); }});
    all.push_back({l_shape(6, 0.06), [](const Vector3d& x) {
                       const Vector3d o = Vector3d::Zero();
                       return std::max(box_depth(x, o, Vector3d(0.03, 0.06, 0.06)),
                                       box_depth(x, o, Vector3d(0.06, 0.06, 0.03)));
                   }});
    all.push_back({torus_shape(48, 24, 0.05, 0.02),
                   [](const Vector3d& x) { return 0.0194 - std::hypot(std::hypot(x.x(), x.y()) - 0.05, x.z()); }});
    all.push_back(tapered("wedge", 5, Vector3d(0.03, 0.03, 0.03), 0.02, false));
    all.push_back(tapered("needle", 6, Vector3d(0.006, 0.006, 0.06), 0.02, true));
    for (const Solid& solid : odd_solids()) all.push_back(solid);
    return all;
}

struct Strokes {
    int strokes = 0, inside = 0, lost = 0, through = 0;
    std::uint32_t most_steps = 0, most_energies = 0, slide_limits = 0, walk_limits = 0;
};

/// From just outside of a random patch straight inwards, 10 ticks, at 0.01 to 5 m/s.
void stroke(const Solid& solid, const TestModel& model, Finger& finger, std::mt19937& random, Strokes& result) {
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    std::uniform_int_distribution<int> any(0, int(model.servo().patch.size()) - 1);
    const int patch = any(random);
    Vector3d alpha(uniform(random), uniform(random), uniform(random));
    alpha /= alpha.sum();
    const Vector3d a = model.corner(patch, 0), b = model.corner(patch, 1), c = model.corner(patch, 2);
    const Vector3d n = (b - a).cross(c - a).normalized();
    const double step = 1e-3 * 0.01 * std::pow(500.0, uniform(random));
    Vector3d x = alpha[0] * a + alpha[1] * b + alpha[2] * c + (step * uniform(random) + 2e-6) * n;
    if (solid.depth(x) > -1e-6) return;
    Vector3d way = random_direction(random);
    if (way.dot(n) > 0.0) way = -way;
    way = (way - 0.5 * n).normalized();
    ++result.strokes;
    finger.begin();
    finger.to(x);
    for (int tick = 0; tick < 10; ++tick) {
        const Vector3d last = x;
        const std::uint32_t before = finger.counters().contacts;
        const bool touched = finger.touches();
        x += step * way;
        finger.to(x);
        const bool inside = solid.depth(x) > 1e-6, crossed = solid.depth(0.5 * (last + x)) > 1e-6;
        result.inside += inside;
        if (inside && !finger.touches()) ++result.lost;
        if (crossed && !touched && finger.counters().contacts == before) ++result.through;
    }
}

Strokes run_strokes(const Solid& solid, GodObject god_object, int count) {
    const TestModel model(solid.shape, -1e9, god_object);
    Finger finger(*model.get());
    std::mt19937 random(17);
    Strokes result;
    while (result.strokes < count) stroke(solid, model, finger, random, result);
    result.most_steps = finger.counters().most_steps;
    result.most_energies = finger.counters().most_energies;
    result.walk_limits = finger.counters().walk_limits;
    result.slide_limits = finger.counters().slide_limits;
    return result;
}

void expect_held(GodObject god_object) {
    Strokes sum;
    for (const Solid& solid : solids()) {
        const Strokes s = run_strokes(solid, god_object, 20'000);
        EXPECT_EQ(s.lost, 0) << solid.shape.name;
        EXPECT_EQ(s.through, 0) << solid.shape.name;
        EXPECT_LE(s.most_steps, std::uint32_t{MOST_STEPS}) << solid.shape.name;
        EXPECT_LE(s.most_energies, std::uint32_t{MOST_ENERGIES}) << solid.shape.name;
        EXPECT_EQ(s.slide_limits, 0U) << solid.shape.name;
        printf(
            "%-10s %-12s %d strokes, %d ticks inside, %d lost, %d through, at most %u steps, %u energies, %u at a "
            "limit\n",
            word(god_object), solid.shape.name.c_str(), s.strokes, s.inside, s.lost, s.through, s.most_steps,
            s.most_energies, s.walk_limits);
        sum.inside += s.inside;
    }
    EXPECT_GT(sum.inside, 700'000);
}

TEST(Strokes, WithTheNearestGodObjectLoseNoContact) { expect_held(GodObject::kNearest); }

TEST(Strokes, WithTheLeastEnergyGodObjectLoseNoContact) { expect_held(GodObject::kLeastEnergy); }

// Slowly out through a tip where 30 patches meet, and in again: inside there is contact, outside there is none.
TEST(Strokes, InsideAndOutsideAreToldApartAtATipOf30Patches) {
    const Solid solid = convex(spindle_shape(30, 0.02, 0.03));
    const TestModel model(solid.shape);
    Finger finger(*model.get());
    std::mt19937 random(3);
    int out = 0;
    for (int way = 0; way < 2000; ++way) {
        const Vector3d tip(0, 0, 0.03), aside = Vector3d(random_direction(random)).cross(Vector3d::UnitZ());
        const Vector3d far = tip + 0.0008 * Vector3d::UnitZ() + 0.0011 * aside, deep = tip - 0.002 * Vector3d::UnitZ();
        finger.begin();
        for (int tick = 0; tick <= 120; ++tick) {
            const double s = std::abs(tick - 60) / 60.0;
            const Vector3d x = ((1.0 - s) * deep + s * far).cast<float>().cast<double>();
            finger.to(x);
            const double depth = solid.depth(x);
            if (std::abs(depth) > 1e-6) {
                EXPECT_EQ(finger.touches(), depth > 0.0) << way << " " << tick << " " << depth;
            }
            out += depth < -1e-6;
        }
    }
    EXPECT_GT(out, 10000);
}

/// Feet of the perpendiculars from x on to patches: where the distance to x has a local minimum.
std::vector<Vector3d> feet(const TestModel& model, const Vector3d& x) {
    std::vector<Vector3d> all;
    for (int p = 0; p < int(model.servo().patch.size()); ++p) {
        const Vector3d a = model.corner(p, 0), b = model.corner(p, 1), c = model.corner(p, 2);
        const Vector3d n = (b - a).cross(c - a).normalized(), foot = x - n.dot(x - a) * n;
        const auto left = [&](const Vector3d& p1, const Vector3d& p2) { return n.dot((p2 - p1).cross(foot - p1)) > 0; };
        if (n.dot(x - a) < 0 && left(a, b) && left(b, c) && left(c, a)) all.push_back(foot);
    }
    return all;
}

// On a slow way under a convex surface the god-object is the nearest point of the whole surface. Near a convex edge the
// patches on both sides have a foot of their own, and the god-object keeps the one that it was on: then it is one of
// them.
TEST(NearestGodObject, IsTheTrueNearestPointOfConvexShapes) {
    for (const Vector3d& axes : {Vector3d(1, 1, 1), Vector3d(1, 0.6, 0.4)}) {
        const TestModel model(
            moved(sphere_shape(3, 0.03), [&](const Vector3d& x) { return Vector3d(axes.cwiseProduct(x)); }));
        Finger finger(*model.get());
        std::mt19937 random(2);
        int unique = 0, ticks = 0;
        for (int way = 0; way < 20; ++way) {
            const Vector3d from = random_direction(random), to = (from + 0.2 * random_direction(random)).normalized();
            finger.begin();
            for (int tick = 0; tick <= 100; ++tick) {  // about 0.05 mm a tick, over patches, edges and vertices
                const Vector3d out = axes.cwiseProduct((from + (to - from) * tick / 100.0).normalized());
                finger.to((tick == 0 ? 0.0305 : 0.0294) * out);
                if (!finger.touches()) continue;
                const Vector3d x = (0.0294 * out).cast<float>().cast<double>();
                const std::vector<Vector3d> at = feet(model, x);
                ++ticks;
                unique += at.size() == 1;
                double gap = (finger.god() - model.nearest(x)).norm();
                for (const Vector3d& foot : at)
                    if (at.size() > 1) gap = std::min(gap, (finger.god() - foot).norm());
                ASSERT_WITHIN(gap, rested(model)) << way << " " << tick;
            }
        }
        EXPECT_GT(ticks, 1900);
        EXPECT_GT(unique, ticks / 4);
        printf("nearest god-object: %d of %d ticks with one foot only\n", unique, ticks);
    }
}

/// How much deeper x lies behind some patch's plane than behind the given one's; negative: that one is the nearest.
double deeper_than_any(const TestModel& model, int patch, const Vector3d& x) {
    const auto depth = [&](int p) {
        const Vector3d a = model.corner(p, 0);
        return -(model.corner(p, 1) - a).cross(model.corner(p, 2) - a).normalized().dot(x - a);
    };
    double least = HUGE_VAL;
    for (int p = 0; p < int(model.servo().patch.size()); ++p) least = std::min(least, depth(p));
    return depth(patch) - least;
}

/// Slowly in through a random patch and along under it, as long as no other side is nearer. Returns the ticks inside.
int slow_way(const TestModel& model, double deep_m, Finger& finger, std::mt19937& random) {
    std::uniform_int_distribution<int> any(0, int(model.servo().patch.size()) - 1);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    const int patch = any(random);
    Vector3d alpha(uniform(random), uniform(random), uniform(random));
    alpha /= alpha.sum();
    const Vector3d a = model.corner(patch, 0), b = model.corner(patch, 1), c = model.corner(patch, 2);
    const Vector3d n = (b - a).cross(c - a).normalized(), on = alpha[0] * a + alpha[1] * b + alpha[2] * c;
    const Vector3d along = (random_direction(random).cross(n)).normalized();
    const double depth = deep_m * uniform(random);
    int inside = 0;
    finger.begin();
    for (int tick = 0; tick <= 400; ++tick) {
        const double in = std::min(tick / 100.0, 1.0), aside = std::max(0.0, tick / 100.0 - 1.0);
        const Vector3d out = on + (5e-5 - in * (depth + 5e-5)) * n + 0.003 * aside * along;
        const Vector3d x = out.cast<float>().cast<double>();
        finger.to(x);
        if (deeper_than_any(model, patch, x) > 1e-9) break;
        if (!finger.touches()) continue;
        ++inside;
        EXPECT_WITHIN((finger.god() - model.nearest(x)).norm(), rested(model)) << patch << " " << tick;
    }
    return inside;
}

// A slow finger that came from outside through one side and has that side nearest has its god-object at the nearest
// point of the whole surface. Next to a convex edge it ends where another side is nearer: there the god-object stays
// on its own side until its foot leaves that.
TEST(NearestGodObject, IsTheNearestPointUnderTheSideThatItCameThrough) {
    for (const Solid& solid : solids()) {
        const std::string& name = solid.shape.name;
        if (name != "box" && name != "thin plate" && name != "sphere" && name != "wedge" && name != "needle") continue;
        const TestModel model(solid.shape);
        Finger finger(*model.get());
        std::mt19937 random(6);
        int ticks = 0;
        for (int way = 0; way < 60; ++way) ticks += slow_way(model, 0.002, finger, random);
        EXPECT_GT(ticks, 2000) << name;
        printf("%s: the nearest point in %d ticks\n", name.c_str(), ticks);
    }
}

/// Every point of the surface as stiff as a spring of 500 N/m.
class EvenBlocks {
public:
    explicit EvenBlocks(const ElasticBody& body) : stiffness_(6 * body.servo().free_count), compliance_(20000 * 6) {
        for (std::size_t i = 0; i < stiffness_.size(); ++i) stiffness_[i] = i % 6 < 3 ? 500.0F : 0.0F;
        for (std::size_t i = 0; i < compliance_.size(); ++i) compliance_[i] = i % 6 < 3 ? 1.0F / 500.0F : 0.0F;
    }
    haptable_model in(haptable_model model) {
        model.stiffness_n_per_m = reinterpret_cast<const float(*)[6]>(stiffness_.data());
        if (model.compliance == nullptr) return model;
        polynomial_ = *model.compliance;
        polynomial_.vertex = polynomial_.edge = polynomial_.patch =
            reinterpret_cast<const float(*)[6]>(compliance_.data());
        model.compliance = &polynomial_;
        return model;
    }

private:
    std::vector<float> stiffness_, compliance_;
    haptable_compliance polynomial_{};
};

/// Largest change of the tangential force from tick to tick, sliding at 100 mm/s, in units of k v dt.
double buzz(const haptable_model& model, double k) {
    Finger finger(model);
    finger.to({0.006, 0.011, 0.031});
    finger.to({0.006, 0.011, 0.028});
    double most = 0.0;
    Vector3d before = finger.force();
    for (int tick = 1; tick <= 180; ++tick) {
        finger.to({0.006 + 1e-4 * tick, 0.011 + 0.3e-4 * tick, 0.028});
        EXPECT_TRUE(finger.touches());
        const Vector3d change = finger.force() - before;
        most = std::max(most, change.head<2>().norm() / (k * 1.044e-4));
        before = finger.force();
    }
    return most;
}

TEST(Feel, SlidingOnAFlatFaceHasNoBuzz) {
    for (const ForceLaw force : every<ForceLaw>())
        for (const GodObject god : every<GodObject>()) {
            const ElasticBody body(cube_scene(9, 0.3), force, 0.006);
            EvenBlocks even(body);
            const double spring = buzz(even.in(body.model(god)), 500.0);
            EXPECT_WITHIN(spring, .epsilon = 0.05) << force << " " << god;
            const double elastic = buzz(body.model(god), 70.0);
            printf("%-14s %-12s even %.1e, elastic cube %.3f of k v dt a tick\n", word(force), word(god), spring,
                   elastic);
        }
}

/// How far the float servo's force is from the double one's, as a rounding of the positions, ticks in order of size.
struct Digits {
    std::vector<double> difference;
    int parted = 0;
};

/// The finger waits there as long as a tick's steps do not do for its god-object to come to rest.
void rest_at(const Vector3d& x, Finger& finger) {
    std::uint32_t limits = 0;
    int ticks = 0;
    do {
        limits = finger.counters().walk_limits;
        finger.to(x);
    } while (finger.counters().walk_limits != limits && ++ticks < 10);
}

Digits compare(const ElasticBody& body, GodObject god_object, unsigned seed) {
    haptable_model model = body.model(god_object);
    model.max_force_n = 1e6F;
    Finger finger(model);
    ReferenceServo reference(model);
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> any(0, body.patches() - 1);
    Digits digits;
    for (int way = 0; way < 60; ++way) {
        const int patch = any(random);
        const Vector3d n = body.normal(patch), start = body.point(patch, Vector3d(0.3, 0.3, 0.4));
        const Vector3d along = random_direction(random).cross(n).normalized();
        for (int tick = 0; tick < 200; ++tick) {
            const double s = tick / 199.0;
            Vector3d x = start + (0.001 - 0.004 * std::sin(std::numbers::pi * s)) * n + 0.008 * s * along;
            x = x.cast<float>().cast<double>();
            rest_at(x, finger);
            const ReferenceServo::Tick tock = reference.step(x);
            if (!finger.touches() || tock.state != HAPTABLE_CONTACT) continue;
            if (tock.force.norm() < 1e-3) continue;
            // u, and with it the force, is a difference of positions.
            const double condition = body.size() / (x - tock.god).norm();
            const double difference = (finger.force() - tock.force).norm() / tock.force.norm();
            if (difference < 1e-3) {
                digits.difference.push_back(difference / condition);
                continue;
            }
            // Parted at a tie: both must be minima, and both go on from the float's.
            ++digits.parted;
            reference.set_contact(finger.out().patch, to_vector(finger.out().alpha), x);
            const ReferenceServo::Tick again = reference.step(x);
            const auto energy = [&](const ReferenceServo::Tick& at) { return -0.5 * at.force.dot(x - at.god); };
            const double energy_j = -0.5 * finger.force().dot(x - finger.god());
            EXPECT_WITHIN(std::abs(energy(again) - energy_j), .count = 16, .epsilon = kFloat, .condition = condition,
                          .size = energy(again))
                << god_object << " is no minimum";
        }
    }
    std::sort(digits.difference.begin(), digits.difference.end());
    return digits;
}

TEST(Feel, FloatsGiveTheForceOfDoubles) {
    for (const ForceLaw force : every<ForceLaw>())
        for (const GodObject god : every<GodObject>()) {
            const ElasticBody body(cube_scene(5, 0.3), force, 0.008);
            const Digits d = compare(body, god, 4);
            ASSERT_GT(d.difference.size(), 3000U);
            const double at_999 = d.difference[d.difference.size() * 999 / 1000];
            EXPECT_WITHIN(at_999, .count = 16, .epsilon = kFloat) << force << " " << god;
            EXPECT_LT(d.parted, int(d.difference.size() / 500)) << force << " " << god;
            printf("%-14s %-12s %zu ticks, 99.9 %%: %.1e, worst %.1e, parted %d\n", word(force), word(god),
                   d.difference.size(), at_999, d.difference.back(), d.parted);
        }
}

}  // namespace
}  // namespace haptable::test
