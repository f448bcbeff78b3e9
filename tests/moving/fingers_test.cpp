// SPDX-License-Identifier: GPL-2.0-or-later
// Two fingers on held bodies, moved as no hand would: where they are on the surface, what they feel when they are
// swapped, and what they get around closed loops.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>

#include "tests/bodies.hpp"
#include "tests/hand.hpp"
#include "tests/moving/adapter.hpp"
#include "tests/moving/bodies.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector3d;
using Fingers = std::array<Vector3d, 2>;

constexpr std::size_t kBodies = 9;

const Shaped& body_of(std::size_t body) {
    static const std::array<Shaped, kBodies> shaped{block(), plate(), rod(),        ball(), ring(),
                                                    lump(),  slab(),  noisy_scan(), sheet()};
    return shaped[body];
}

Scene scene_of_two(std::size_t body, ForceLaw force, const std::filesystem::path& folder) {
    return scene_of(body_of(body), false, 0, force, 2, folder);
}

/// Points of a body's surface, of the tables that the servo has.
class Surface {
public:
    Surface(const MovingTables& tables, std::mt19937& random) : servo_(tables.servo()), random_(random) {}

    double part() { return std::uniform_real_distribution<double>(0.0, 1.0)(random_); }
    Vector3d any_direction() {
        std::normal_distribution<double> normal;
        return Vector3d(normal(random_), normal(random_), normal(random_)).normalized();
    }
    std::size_t any_patch() {
        return std::min(servo_.patch.size() - 1, std::size_t(part() * double(servo_.patch.size())));
    }
    Vector3d corner(std::size_t patch, int c) const {
        const auto& x = servo_.vertex_m[servo_.patch[patch][std::size_t(c)]];
        return {double(x[0]), double(x[1]), double(x[2])};
    }
    Vector3d normal(std::size_t patch) const {
        const Vector3d a = corner(patch, 0);
        return (corner(patch, 1) - a).cross(corner(patch, 2) - a).normalized();
    }
    Vector3d any_point(std::size_t patch) {
        double a = part(), b = part();
        if (a + b > 1.0) a = 1.0 - a, b = 1.0 - b;
        return corner(patch, 0) + a * (corner(patch, 1) - corner(patch, 0)) + b * (corner(patch, 2) - corner(patch, 0));
    }
    Vector3d at(std::size_t patch, const Vector3d& alpha) const {
        return alpha[0] * corner(patch, 0) + alpha[1] * corner(patch, 1) + alpha[2] * corner(patch, 2);
    }
    double smallest_m() const {
        double least2 = HUGE_VAL;
        for (std::size_t p = 0; p < servo_.patch.size(); ++p)
            least2 = std::min(least2, (corner(p, 1) - corner(p, 0)).squaredNorm());
        return std::sqrt(least2);
    }

private:
    const ServoModel& servo_;
    std::mt19937& random_;
};

/// Fingers that jump from patch to patch, tremble over edges, press side by side and leave one another behind.
class Adversary {
public:
    Adversary(const MovingTables& tables, std::mt19937& random)
        : surface_(tables, random), size_m_(tables.size_m()), edge_m_(surface_.smallest_m()) {
        for (std::size_t f = 0; f < 2; ++f) begin(f);
    }
    Fingers next() {
        for (std::size_t f = 0; f < 2; ++f) {
            if (--left_[f] < 0) want(f);
            at_[f] += step_[f];
            if (trembles_[f]) at_[f] += 0.02 * edge_m_ * surface_.part() * surface_.any_direction();
        }
        return at_;
    }

private:
    void begin(std::size_t f) {
        const std::size_t patch = surface_.any_patch();
        at_[f] = surface_.any_point(patch) + 0.05 * size_m_ * surface_.normal(patch);
        step_[f].setZero();
    }
    void want(std::size_t f) {
        left_[f] = 2 + int(60.0 * surface_.part() * surface_.part());
        const std::size_t patch = surface_.any_patch();
        Vector3d to = surface_.any_point(patch);
        const double kind = surface_.part();
        if (kind < 0.55)
            to = at_[1 - f] + edge_m_ * 2.0 * surface_.part() * surface_.any_direction();
        else if (kind < 0.8)
            to = at_[f] + edge_m_ * 3.0 * surface_.part() * surface_.any_direction();
        else
            to += (0.03 - 0.12 * surface_.part()) * size_m_ * surface_.normal(patch);
        trembles_[f] = surface_.part() < 0.3;
        step_[f] = (to - at_[f]) / (left_[f] + 1);
        if (step_[f].norm() > 0.002) step_[f] *= 0.002 / step_[f].norm();
        if (surface_.part() < 0.02) begin(f);
    }

    Surface surface_;
    double size_m_, edge_m_;
    Fingers at_{};
    Fingers step_{};
    std::array<int, 2> left_{0, 0};
    std::array<bool, 2> trembles_{false, false};
};

class TwoOnABody : public testing::TestWithParam<std::size_t> {
protected:
    const TemporaryFolder folder;
};

// HAPTABLE_TICKS=... of each body, force, god-object, with friction and without.
TEST_P(TwoOnABody, GodObjectsAreOnTheSurfaceInEveryTick) {
    const int ticks = asked("HAPTABLE_TICKS", 2000);
    long touched = 0, all = 0;
    double sum = 0.0, off = 0.0;
    for (const ForceLaw force : kForces) {
        const MovingTables tables(scene_of_two(GetParam(), force, folder.path() / word(force)));
        for (int kind = 0; kind < 4; ++kind) {
            std::mt19937 random(static_cast<unsigned>(1 + kind + 10 * int(force)));
            const Surface surface(tables, random);
            Touching touching;
            touching.fingers = 2;
            touching.friction = kind % 2 == 0 ? 0.0 : 0.5;
            touching.god_object = kind / 2 == 0 ? GodObject::kLeastEnergy : GodObject::kNearest;
            MovingSession session(tables, touching);
            Adversary adversary(tables, random);
            for (int tick = 0; tick < ticks; ++tick) {
                session.step(adversary.next());
                for (int f = 0; f < 2; ++f) {
                    const Felt& felt = session.felt(f);
                    ASSERT_TRUE(felt.is_sound) << word(force) << " kind " << kind << " tick " << tick;
                    ++all;
                    if (!felt.touches) continue;
                    ++touched;
                    sum = std::max(sum, std::abs(felt.alpha.sum() - 1.0));
                    off = std::max(off, (surface.at(std::size_t(felt.patch), felt.alpha) - felt.god_m).norm());
                    ASSERT_WITHIN(std::abs(felt.alpha.sum() - 1.0), .count = 4, .epsilon = kFloat)
                        << word(force) << " kind " << kind << " tick " << tick << " finger " << f << ": "
                        << felt.alpha.transpose() << " of patch " << felt.patch;
                    ASSERT_GE(felt.alpha.minCoeff(), 0.0) << word(force) << " kind " << kind << " tick " << tick;
                    ASSERT_LE(felt.alpha.maxCoeff(), 1.0) << word(force) << " kind " << kind << " tick " << tick;
                }
            }
        }
    }
    EXPECT_WITHIN(off, .count = 8, .epsilon = kFloat, .size = 0.1);
    EXPECT_GT(touched, all / 10);
    RecordProperty("touched", std::to_string(touched));
}

// C is symmetric, and so is all that two nearest god-objects feel: to the rounding of a solve for six unknowns, of
// which at least a 64th is definite. On the slab two fingers come to load one node alone, next to fixed ones, where
// which of them touches is not to hang on rounding.
TEST_P(TwoOnABody, SwappedFingersFeelSwappedForces) {
    const int ticks = asked("HAPTABLE_TICKS", body_of(GetParam()).name == "slab" ? 50000 : 2000);
    int both = 0;
    for (const ForceLaw force : kForces) {
        const MovingTables tables(scene_of_two(GetParam(), force, folder.path() / word(force)));
        std::mt19937 random(static_cast<unsigned>(100 + int(force)));
        Touching touching;
        touching.fingers = 2;
        touching.god_object = GodObject::kNearest;
        MovingSession session(tables, touching), swapped(tables, touching);
        Adversary adversary(tables, random);
        for (int tick = 0; tick < ticks; ++tick) {
            const Fingers at = adversary.next();
            session.step(at);
            swapped.step({at[1], at[0]});
            double size_n = 0.0;  // of a solve the larger of the two sides, as the stiffness has it
            for (int f = 0; f < 2; ++f) {
                const Felt& felt = session.felt(f);
                const double dent_m = felt.touches ? (felt.inside_m - felt.god_m).norm() : 0.0;
                size_n += std::max(tables.stiffness_limit_n_per_m() * dent_m, felt.force_n.norm());
            }
            for (int f = 0; f < 2; ++f) {
                ASSERT_EQ(session.felt(f).god_m, swapped.felt(1 - f).god_m) << word(force) << " tick " << tick;
                ASSERT_WITHIN((session.felt(f).force_n - swapped.felt(1 - f).force_n).norm(), .count = 16,
                              .epsilon = kFloat, .condition = 64.0, .size = size_n)
                    << word(force) << " tick " << tick << " finger " << f << ": " << session.felt(f).force_n.transpose()
                    << " and " << swapped.felt(1 - f).force_n.transpose();
            }
            both += session.felt(0).force_n.norm() > 0.0 && session.felt(1).force_n.norm() > 0.0;
        }
    }
    EXPECT_GT(both, ticks / 4);
}

/// A finger's closed path: it waits, goes in, aside and out, and comes home outside.
struct Loop {
    Vector3d home, normal, aside;
    double deep_m = 0.0;
    int wait = 0, in = 0, along = 0, stay = 0;
    int ticks() const { return wait + 3 * in + 2 * along + stay; }
    Vector3d at(int tick) const {
        const auto part = [&tick](int length) {
            const double done = std::clamp(double(tick) / length, 0.0, 1.0);
            tick -= length;
            return done;
        };
        tick -= wait;
        const double in1 = part(in), along1 = part(along);
        tick -= stay;
        const double out = part(2 * in), back = part(along);
        return home + (2.0 * out - in1) * deep_m * normal - out * deep_m * normal + (along1 - back) * aside;
    }
};

/// At most so fast, m a tick.
constexpr double kSlow_m = 1e-5;

Loop any_loop(Surface& surface, double size_m, double slow_m) {
    Loop loop;
    const std::size_t patch = surface.any_patch();
    loop.normal = surface.normal(patch);
    loop.home = surface.any_point(patch) + 1e-4 * loop.normal;
    loop.deep_m = 1e-4 + (0.01 + 0.06 * surface.part()) * size_m;
    loop.aside = (0.1 * size_m * surface.part()) * loop.normal.cross(surface.any_direction()).normalized();
    loop.wait = int(300 * surface.part());
    loop.stay = int(300 * surface.part());
    loop.in = 1 + int(loop.deep_m / slow_m);
    loop.along = 1 + int(loop.aside.norm() / slow_m);
    return loop;
}

// HAPTABLE_LOOPS=... of each body and force.
TEST_P(TwoOnABody, ClosedLoopsGiveNoEnergy) {
    const int loops = asked("HAPTABLE_LOOPS", 6);
    int broken = 0, stepped = 0, met = 0;
    double worst = -HUGE_VAL, largest = 0.0;
    std::string where, where_stepped;
    for (const ForceLaw force : kForces) {
        const MovingTables tables(scene_of_two(GetParam(), force, folder.path() / word(force)));
        Touching touching;
        touching.fingers = 2;
        for (int number = 0; number < loops; ++number) {
            std::mt19937 random(static_cast<unsigned>(number + 1000 * int(force)));
            Surface surface(tables, random);
            const std::array<Loop, 2> loop{any_loop(surface, tables.size_m(), kSlow_m),
                                           any_loop(surface, tables.size_m(), kSlow_m)};
            MovingSession session(tables, touching);
            double given_j = 0.0, paid_j = 0.0;
            std::array<Felt, 2> last;
            const int ticks = std::max(loop[0].ticks(), loop[1].ticks()) + 1;
            for (int tick = 0; tick <= ticks; ++tick) {
                session.step({loop[0].at(tick), loop[1].at(tick)});
                double way_m = 0.0;
                for (int f = 0; f < 2 && tick > 0; ++f) {
                    const Vector3d way = session.felt(f).at_m - last[std::size_t(f)].at_m;
                    given_j += 0.5 * (session.felt(f).force_n + last[std::size_t(f)].force_n).dot(way);
                    way_m += way.norm();
                }
                paid_j = std::max(paid_j, -given_j);
                for (int f = 0; f < 2 && tick > 0; ++f) {
                    const Felt &now = session.felt(f), &other = session.felt(1 - f);
                    const Felt &was = last[std::size_t(f)], &other_was = last[std::size_t(1 - f)];
                    if (!now.touches || was.touches || !other_was.touches || !other.touches) continue;
                    ++met;
                    const double step_n =
                        std::max((now.force_n - was.force_n).norm(), (other.force_n - other_was.force_n).norm());
                    const double part = step_n / (tables.stiffness_limit_n_per_m() * way_m);
                    stepped += part > 2.0;
                    if (part > largest)
                        largest = part, where_stepped = word(force) + std::string(", loop ") + std::to_string(number) +
                                                        ", tick " + std::to_string(tick);
                }
                last = {session.felt(0), session.felt(1)};
            }
            if (!(paid_j > 1e-9) || last[0].touches || last[1].touches) continue; /* home is within another part */
            broken += given_j > 1e-3 * paid_j;
            if (given_j / paid_j > worst)
                worst = given_j / paid_j, where = word(force) + std::string(", loop ") + std::to_string(number);
        }
    }
    EXPECT_EQ(broken, 0) << "worst " << worst << " of what the hands had paid: " << where;
    EXPECT_EQ(stepped, 0) << "a force stepped by " << largest << " times the body's stiffness, of " << met
                          << " meetings: " << where_stepped;
    EXPECT_GT(met, 0);
}

std::string name_of_body(const testing::TestParamInfo<std::size_t>& info) { return body_of(info.param).name; }
INSTANTIATE_TEST_SUITE_P(Bodies, TwoOnABody, testing::Range<std::size_t>(0, kBodies), name_of_body);

}  // namespace
}  // namespace haptable::test
