// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/strokes/judge.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

namespace haptable {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Ten times the servo's own tolerance, 2^-20 of the size: nearer to the surface, inside and outside are rounding.
constexpr double kClear = 1e-5;
// A hundredth of the size, for 3 ticks: a search that met HAPTABLE_TICK_BOXES goes on at the next tick.
constexpr double kDeep = 0.01;
constexpr int kDeepTicks = 3;
// What a limit left open, which is counted, is decided within these ticks, or the contact is given up.
constexpr int kLimitTicks = 20;
// A search for who presses adds nobody after so many factorisations.
constexpr int kSets = HAPTABLE_POINTS_SETS / 2;
constexpr double kLaw = 1e-4;
// Roundings of a float of size 1 that a god-object's coordinates, and their difference to the finger, may have.
constexpr double kRoundings = 8.0 * 0x1p-24;
constexpr double kEnergy = 1e-3;
constexpr double kFloat = 0x1p-24;
// Roundings: of a sum of area coordinates; of what a tick changes a momentum by.
constexpr double kSumOfAreas = 4.0, kImpulse = 16.0;
// Of a smaller force a float has no square: whether it counts is rounding.
constexpr double kNoForce_n = 1e-18;
// The arccosine that weighs normals at vertices is good to 7e-5; 3 of them for the two legs and the sum.
constexpr double kCone = 1e-3;

/// Ascending.
Vector3d eigenvalues(const Matrix3d& s) {
    return Eigen::SelfAdjointEigenSolver<Matrix3d>(s, Eigen::EigenvaluesOnly).eigenvalues();
}

fmt::join_view<const double*, const double*> listed(const Vector3d& x) {
    return fmt::join(x.data(), x.data() + 3, ",");
}

Vector3d cut(const Vector3d& force_n, double most_n) {
    const double size = force_n.norm();
    return size > most_n ? Vector3d(most_n / size * force_n) : force_n;
}

/// The largest of three vectors.
double largest_of(const Matrix3d& columns) { return columns.colwise().norm().maxCoeff(); }

/// What one tick gave, and what it should have.
struct Tick {
    Felt felt;
    Vector3d x = Vector3d::Zero();  ///< in the frame of the body's surface at rest
    bool contact = false;
    SurfacePoint at;
    Vector3d god = Vector3d::Zero();       ///< of a point the nearest
    Vector3d loaded_m = Vector3d::Zero();  ///< the god-object that `at` tells of: of a point its load's
    Vector3d raised_m = Vector3d::Zero();  ///< where another finger had raised the surface
    Matrix3d s = Matrix3d::Zero();         ///< S(god), from the tables
    StiffeningCurve curve;                 ///< of the dent
    Vector3d load_n = Vector3d::Zero();    ///< Psi' S u
    Vector3d law_n = Vector3d::Zero();     ///< -Psi' S u, cut to max_force
    Matrix3d nodal_n = Matrix3d::Zero();   ///< a column each, as the servo published them
    haptable_counters counters{};
    bool has_limit = false;  ///< was met in it
    // Of a point, which a tool or each of many fingers has:
    bool presses = false;
    Vector3d normal = Vector3d::Zero();  ///< outward

    Vector3d u() const { return x - god; }
    Vector3d dent() const { return u() + raised_m; }
    Vector3d loaded_u() const { return x - loaded_m + raised_m; }
    double linear_j(const Vector3d& finger) const {
        const Vector3d dent = finger - god + raised_m;
        return 0.5 * dent.dot(s * dent);
    }
    /// Energy of the spring that the contact is while the god-object stands still.
    double energy_at(const Vector3d& finger) const { return contact ? curve.stored(linear_j(finger)) : 0.0; }
    double energy_j() const { return energy_at(x); }
    /// Of the dent, beside a linear one's.
    double largest_tangent() const { return curve.largest_tangent(linear_j(x)); }
    std::size_t limits() const {
        return std::size_t{counters.walk_limits} + counters.slide_limits + counters.box_limits;
    }
    Vector3d released_n() const { return felt.force_n - law_n; }
};

/// What was given beyond what was stored when it began to be given.
struct Account {
    double given_j = 0.0, held_j = 0.0, rounding_j = 0.0;

    void begin() { given_j = held_j = 0.0; }
    /// One tick; rounded_j: what rounding may make of it. False where too much was given.
    bool note(double more_j, double stored_j, double rounded_j, Verdict& verdict) {
        given_j += more_j;
        held_j = std::min(held_j, given_j + stored_j);
        rounding_j = std::max(rounding_j, rounded_j);
        verdict.most_stored_j = std::max(verdict.most_stored_j, stored_j);
        verdict.most_given_j = std::max(verdict.most_given_j, given_j - held_j);
        return given_j - held_j <= kEnergy * verdict.most_stored_j + rounding_j;
    }
};

/// A tick of the whole scene, and what the stroke has come to.
struct SceneTick {
    int index = 0;
    bool rests = false;      ///< no finger has moved
    bool has_limit = false;  ///< was met by any finger, in it or the last
    Motion before, after;    ///< of a free body
    std::string faults;      ///< of the tick
    Verdict verdict;

    void expect(bool holds, Fault otherwise) {
        if (holds) return;
        int& first = verdict.tick[static_cast<std::size_t>(otherwise)];
        if (first < 0) first = index;
        const std::string name(name_of(otherwise));
        if (faults.find(name) == std::string::npos) faults += (faults.empty() ? "" : " ") + name;
    }
};

/// One finger of a stroke.
class FingerTrial {
public:
    FingerTrial(const Touched& touched, SceneState& scene, std::size_t finger, SceneTick& tick)
        : touched_(touched),
          model_(touched.model),
          scene_(scene),
          servo_(touched.has_points() ? scene.point_servo(finger) : scene.servo(finger)),
          finger_(finger),
          tick_(tick),
          where_(touched.on.solid) {}

    void keep() {
        before_ = servo_;
        if (is_alone() && model_.frictionless != nullptr) freed_before_ = *freed();
        last_ = now_;
    }

    /// What a point of a tool has come to.
    void take() {
        now_ = Tick();
        now_.counters = servo_.counters;
        now_.has_limit = now_.limits() != last_.limits();
        if (touched_.has_points()) take_point(scene_.point_state(finger_));
    }
    /// Of a finger also what its hand did and was given.
    void take(const haptable_input& in, const haptable_output& out) {
        take();
        take_hand(in, out);
    }

    void check() {
        if (has_hand()) check_force();
        check_sides();
        if (now_.contact) check_area();
        if (touched_.has_points()) check_point();
        if (!touched_.has_points() && now_.contact) check_law();
        if (has_hand() && !since_.is_first) check_change();
        if (is_alone() && model_.energy != nullptr && !tick_.verdict.clamped) check_energy();
        if (is_alone() && model_.frictionless != nullptr && now_.contact && last_.contact) check_cone();
        since_.is_first = false;
    }

    /// A position that is none: the next one begins a session.
    void begin() {
        tick_.expect(now_.felt.force_n.norm() == 0.0, Fault::kForce);
        last_ = now_ = Tick();
        since_ = Session();
        account_.begin();
    }

    const Tick& now() const { return now_; }
    Vector3d motion_m() const { return now_.x - last_.x; }
    /// One that touches and does not press may have begun within the tick.
    bool may_begin() const {
        return now_.contact && (!now_.presses || now_.counters.contacts != last_.counters.contacts);
    }
    bool fades() const { return servo_.fade_ticks != 0; }
    double rounding_m() const { return rounding_m_; }
    bool has_limit() const { return now_.has_limit || last_.has_limit; }

    /// A line of kJudgedColumns. given_j: where the whole scene's is judged.
    std::string describe(double given_j) {
        const SurfacePoint& g = now_.at;
        return fmt::format(
            "{},{},{:.9g},{:d},{:d},{:d},{},{:.6g},{:.9g},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{}\n",
            tick_.index, finger_, listed(now_.x), now_.contact, where_.is_inside(now_.x), sees_god(),
            now_.contact ? std::to_string(g.patch) : "", listed(g.alpha), listed(now_.god), now_.limits(),
            touched_.on.solid.gap_m(now_.x), now_.felt.force_n.norm(), now_.law_n.norm(), change_n().norm(),
            now_.energy_j(), is_alone() ? account_.given_j : given_j, tick_.faults);
    }

private:
    /// One finger on a body at rest: all that it gives hangs on its own path.
    bool is_alone() const { return touched_.pair == nullptr && !touched_.has_points() && !moves(); }
    bool moves() const { return touched_.body() != nullptr || touched_.modes() != nullptr; }
    bool has_hand() const { return touched_.tool() == nullptr; }
    Vector3d change_n() const { return now_.felt.force_n - last_.felt.force_n; }
    double clear_m() const { return kClear * touched_.on.solid.size_m(); }
    double most_n() const { return static_cast<double>(model_.max_force_n); }
    haptable_freed* freed() const { return haptable_freed_of(&model_, &servo_); }

    // ---- what the servo says ----

    /// In the body's frame. How far modes have moved the surface is the servo's word.
    Vector3d inside_of(const Felt& felt) const {
        if (touched_.modes() != nullptr) return felt.inside_m;
        const haptable_body* body = touched_.body();
        if (body == nullptr) return felt.at_m;
        return tick_.before.turn.conjugate() * (felt.at_m - tick_.before.centre_m) + to_vector(body->centre_m);
    }

    /// Where a point's contact begins and ends the nearest god-object tells.
    void take_point(const haptable_point& point) {
        now_.felt.at_m = now_.x = to_vector(servo_.finger_m);
        now_.contact = point.is_inside != 0;
        now_.presses = point.presses != 0;
        rounding_m_ = kRoundings * (touched_.on.solid.reach_m() + now_.x.norm());
        now_.load_n = now_.felt.force_n = to_vector(point.load_n);
        if (!now_.contact) return;
        now_.at = {point.at.patch, to_vector(point.at.alpha)};
        now_.god = to_vector(servo_.contact.god_object_m);
        now_.loaded_m = to_vector(point.at.god_object_m);
        now_.normal = to_vector(point.normal);
        now_.raised_m = static_cast<double>(point.raised_m) * now_.normal + to_vector(point.sunk_m);
    }

    /// Of one of many fingers its point has the load.
    void take_hand(const haptable_input& in, const haptable_output& out) {
        now_.felt = felt_of(scene_, finger_, in, out);
        now_.nodal_n = Eigen::Map<const Eigen::Matrix3f>(out.nodal_force_n[0]).cast<double>();
        now_.contact = out.state == HAPTABLE_CONTACT;
        if (now_.contact) now_.at = {out.patch, to_vector(out.alpha)};
        if (now_.contact) now_.loaded_m = now_.felt.god_m;
        if (touched_.has_points()) {
            const double faded = static_cast<double>(servo_.fade_ticks) / HAPTABLE_FADE_TICKS;
            now_.law_n = (1.0 - faded) * cut(-now_.load_n, most_n());
            return;
        }
        if (model_.release != nullptr) now_.felt.released_n = now_.felt.force_n + now_.felt.load_n;
        now_.x = inside_of(now_.felt);
        rounding_m_ =
            kRoundings * (touched_.on.solid.reach_m() + (touched_.body() != nullptr ? now_.felt.at_m.norm() : 0.0));
        if (!now_.contact) return;
        now_.god = now_.loaded_m;
        if (const haptable_pair* pair = scene_.pair(); pair != nullptr)
            now_.raised_m = to_vector(pair->view[finger_].raised_m);
        now_.s = touched_.on.law.stiffness(now_.at);
        now_.curve = touched_.on.law.curve();
        now_.load_n = now_.curve.factor(now_.linear_j(now_.x)) * (now_.s * now_.dent());
        now_.law_n = cut(-now_.load_n, most_n());
    }

    // ---- inside and outside ----

    /// The last motion was clearly inside midway from where it went in to where it came out; one that only touches an
    /// edge was not.
    bool went_through() const {
        const Solid& solid = touched_.on.solid;
        if (solid.sees(last_.x, now_.x)) return false;
        const auto from_last = [&](const Solid::Entry& entry) { return (entry.point_m - last_.x).norm(); };
        const std::vector<Solid::Entry> out = solid.entries(now_.x, last_.x, 0.0);
        for (const Solid::Entry& in : solid.entries(last_.x, now_.x, 0.0)) {
            double to_m = motion_m().norm();
            for (const Solid::Entry& one : out)
                if (from_last(one) > from_last(in)) to_m = std::min(to_m, from_last(one));
            const Vector3d middle = last_.x + 0.5 * (from_last(in) + to_m) * motion_m().normalized();
            if (solid.holds(middle) && solid.gap_m(middle) > clear_m()) return true;
        }
        return false;
    }

    bool is_clearly_outside() { return !where_.is_inside(now_.x) && where_.is_beyond(now_.x, clear_m()); }

    /// In contact, the finger is outside and sees the god-object, which lies on the surface within the servo's
    /// tolerance. No more of the line to it is left out: a wedge may be thinner.
    bool sees_god() {
        if (!now_.contact || !is_clearly_outside()) return false;
        const Vector3d line = now_.x - now_.god;
        const double left_out_m = static_cast<double>(model_.tolerance_m);
        return touched_.on.solid.sees(now_.x, now_.god + std::min(0.5, left_out_m / line.norm()) * line);
    }

    void check_sides() {
        const auto count = [](auto& ticks, bool goes_on) { ticks = goes_on ? ticks + 1 : 0; };
        const bool is_outside = is_clearly_outside(), sees = sees_god();
        count(since_.outside_ticks, sees);
        tick_.expect(since_.outside_ticks <= (has_limit() ? kLimitTicks : 0), Fault::kOutside);
        count(since_.behind_ticks, now_.contact && is_outside && !sees);
        tick_.verdict.most_behind_ticks = std::max(tick_.verdict.most_behind_ticks, since_.behind_ticks);

        const bool was_free = since_.is_free;
        since_.is_free = is_outside && !now_.contact;
        if (was_free && since_.is_free && !where_.is_beyond(now_.x, motion_m().norm()))
            tick_.verdict.passed += went_through() ? 1 : 0;

        since_.came_from_outside |= is_outside || now_.contact;
        count(since_.deep_ticks, !now_.contact && since_.came_from_outside && where_.is_inside(now_.x) &&
                                     where_.is_beyond(now_.x, kDeep * touched_.on.solid.size_m()));
        tick_.expect(since_.deep_ticks < kDeepTicks, Fault::kLost);
    }

    // ---- the force ----

    bool is_cut(const Vector3d& force_n) const { return force_n.norm() >= most_n() * (1.0 - 1e-5); }

    void check_force() {
        tick_.verdict.clamped |= is_cut(now_.load_n) || is_cut(now_.felt.force_n);
        tick_.expect(now_.felt.force_n.norm() <= most_n() * (1.0 + 1e-5), Fault::kForce);
    }

    void check_area() {
        const double missed = std::abs(now_.at.alpha.sum() - 1.0);
        tick_.verdict.most_area = std::max(tick_.verdict.most_area, missed);
        const double off_m = (point_of(touched_.on.servo(), now_.at) - now_.loaded_m).norm();
        tick_.expect(missed <= kSumOfAreas * kFloat && now_.at.alpha.minCoeff() >= 0.0 &&
                         off_m <= kRoundings * touched_.on.solid.reach_m(),
                     Fault::kArea);
    }

    /// A point presses with its load; one of many fingers gives it to its corners and to its hand.
    void check_point() {
        const bool is_load = now_.presses ? now_.contact : now_.load_n.norm() == 0.0;
        tick_.expect(is_load && now_.load_n.allFinite(), Fault::kForce);
        tick_.expect(!(now_.presses && now_.load_n.dot(now_.normal) > 0.0), Fault::kPull);
        if (!has_hand()) return;
        const double error = std::max((now_.felt.force_n - now_.law_n).norm(),
                                      largest_of(now_.nodal_n - now_.load_n * now_.at.alpha.transpose()));
        tick_.expect(error <= kLaw * now_.load_n.norm(), Fault::kLaw);
    }

    /// A body that moves gives a part of the law's force: what nobody has paid for is not given. What two fingers press
    /// at once is no law of either alone.
    void check_law() {
        const haptable_pair* pair = scene_.pair();
        if (pair != nullptr && pair->touches[finger_] != 0 && pair->touches[1 - finger_] != 0) return;
        const Matrix3d law_n = touched_.on.law.nodal_forces(now_.at, now_.s, now_.dent());
        const double square = law_n.squaredNorm();
        double share = 1.0;
        if (moves()) share = square > 0.0 ? std::clamp(law_n.cwiseProduct(now_.nodal_n).sum() / square, 0.0, 1.0) : 0.0;
        if (pair != nullptr && pair->touches[finger_] == 0) share = 0.0;
        const double largest = std::max(now_.load_n.norm(), largest_of(now_.nodal_n));
        double error = largest_of(now_.nodal_n - share * law_n);
        if (is_alone() && model_.release == nullptr) error = std::max(error, (now_.felt.force_n - now_.law_n).norm());
        tick_.expect(error <= kLaw * largest || error <= rounding_of(largest), Fault::kLaw);
        if (!is_alone() || !touched_.on.law.draws(now_.at)) return;
        const double gap_m = (touched_.on.law.drawn(now_.at, now_.nodal_n) - now_.u()).norm();
        tick_.expect(
            gap_m <= kLaw * now_.u().norm() || gap_m <= rounding_of(now_.load_n.norm()) / eigenvalues(now_.s)[0],
            Fault::kDrawn);
    }

    /// The error that a force may have by the rounding of the god-object's coordinates and of the blocks.
    double rounding_of(double force_n) const {
        const Vector3d e = eigenvalues(now_.s);
        return now_.largest_tangent() * e[2] * rounding_m_ + std::max(kLaw, kRoundings * e[2] / e[0]) * force_n;
    }

    // ---- from tick to tick ----

    void check_change() {
        if (model_.release == nullptr || !is_alone())
            check_rest();
        else if (!is_cut(last_.felt.force_n) && !is_cut(now_.felt.force_n))
            check_jump();
        since_.owed_j = now_.contact ? std::max(0.0, since_.owed_j + now_.released_n().dot(motion_m())) : 0.0;
    }

    /// Without release jumps are given as they are: but none where fingers rest on a body that does. Two god-objects
    /// that go by their energy or by friction come to rest after each other, and may take some ticks.
    void check_rest() {
        const bool takes_ticks =
            touched_.pair != nullptr && (model_.energy != nullptr || model_.frictionless != nullptr);
        if (!tick_.rests || moves() || takes_ticks || model_.release != nullptr || tick_.has_limit) return;
        const double rounded = now_.contact ? rounding_of(0.0) : 0.0;
        tick_.expect(!(change_n().norm() > 1e-6 * now_.felt.force_n.norm() + rounded), Fault::kJump);
    }

    /// With release a force changes by a spring's change over the motion, of twice the stiffness, and by the release.
    /// Along the motion what pushed may end at once, of the contact's force and of what is being released. What a
    /// release held back of forces that brake was not paid, and may be taken back: a force that pushed may turn into
    /// one that brakes as much.
    void check_jump() {
        const double way_m = motion_m().norm();
        double slack =
            2.0 * static_cast<double>(model_.release_n) + kLaw * (now_.felt.force_n.norm() + last_.felt.force_n.norm());
        if (change_n().norm() <= slack) return;
        if (now_.contact) {
            double stiffest = eigenvalues(now_.s)[2];  // a god-object may slide far from where its contact began
            for (const Solid::Entry& entry : entries_of_contact())
                stiffest = std::max(stiffest, eigenvalues(spring_at(entry))[2]);
            slack += 2.0 * now_.largest_tangent() * stiffest * (way_m + rounding_m_);
        }
        const Vector3d w = way_m > 0.0 ? Vector3d(motion_m() / way_m) : Vector3d(Vector3d::Zero());
        const double along = std::min(0.0, change_n().dot(w)), brakes = std::max(0.0, -now_.law_n.dot(w));
        const double pushed = std::max(0.0, last_.law_n.dot(w)) + std::max(0.0, last_.released_n().dot(w));
        const double ends = slack + pushed + (pushed > 0.0 ? std::min(pushed, since_.owed_j / way_m) : 0.0);
        const bool is_explained = (change_n() - along * w).norm() <= slack && -along <= ends + brakes;
        tick_.expect(is_explained, Fault::kJump);
        tick_.expect(!is_explained || -along <= ends, Fault::kBrake);
    }

    // ---- energy ----

    /// Where the finger came through the surface to a new contact.
    std::vector<Solid::Entry> entries_of_contact() {
        if (!now_.contact || (last_.contact && now_.counters.contacts == last_.counters.contacts)) return {};
        // A motion may begin within the tolerance behind the surface, and go along it there.
        const Vector3d from = last_.x - clear_m() * motion_m().normalized();
        std::vector<Solid::Entry> entries = touched_.on.solid.entries(from, now_.x, clear_m());
        if (entries.empty() && !where_.is_beyond(last_.x, clear_m()))
            entries.push_back(touched_.on.solid.nearest(last_.x));
        return entries;
    }

    /// What the finger did on a spring there.
    double work_of_entry() {
        double most = 0.0;
        for (const Solid::Entry& entry : entries_of_contact())
            most = std::max(most, 0.5 * (now_.x - entry.point_m).dot(spring_at(entry) * (now_.x - entry.point_m)));
        return touched_.on.law.curve().stored(most);
    }

    Matrix3d spring_at(const Solid::Entry& entry) const {
        const auto corner = [&](std::size_t c) { return corner_of(touched_.on.servo(), entry.triangle, c % 3); };
        const Vector3d n = (corner(1) - corner(0)).cross(corner(2) - corner(0));
        SurfacePoint at{entry.triangle, Vector3d::Zero()};
        for (std::size_t c = 0; c < 3; ++c) {
            const Vector3d a = corner(c + 1), b = corner(c + 2);
            at.alpha[static_cast<int>(c)] = std::max(0.0, n.dot((b - a).cross(entry.point_m - a)) / n.squaredNorm());
        }
        at.alpha /= at.alpha.sum();
        return touched_.on.law.stiffness(at);
    }

    /// What the last tick's contact gives until now, the god-object standing still; where it has ended, until that gave
    /// most.
    double given_by_spring() const {
        if (!last_.contact) return 0.0;
        if (now_.contact) return last_.energy_j() - last_.energy_at(now_.x);
        const Vector3d motion = motion_m();
        const double curvature = motion.dot(last_.s * motion), slope = motion.dot(last_.s * last_.dent());
        const double fraction = curvature > 0.0 ? std::clamp(-slope / curvature, 0.0, 1.0) : 0.0;
        return last_.energy_j() - last_.energy_at(last_.x + fraction * motion);
    }

    /// Until a clamp is met: beyond it the force is no gradient.
    void check_energy() {
        const double given_j = given_by_spring() - work_of_entry() + now_.released_n().dot(motion_m());
        tick_.expect(account_.note(tick_.index > 0 ? given_j : 0.0, now_.energy_j(), now_.load_n.norm() * rounding_m_,
                                   tick_.verdict),
                     Fault::kEnergy);
    }

    // ---- friction ----

    bool is_in_cone(double mu, const Vector3d& normal) const {
        const double pressed = -normal.dot(now_.load_n);
        const double along = (now_.load_n + pressed * normal).norm();
        return along <= mu * pressed + kCone * (1.0 + mu) * now_.load_n.norm() + rounding_of(0.0);
    }

    /// Where the god-object would be without friction, its force is anywhere. Least energy goes on from there as long
    /// as that stores no more than where it was held, whose load is `share` of what the tables say.
    bool is_frictionless(double share) const {
        haptable_model smooth = model_;
        smooth.god_object = model_.frictionless;
        haptable_room room{};
        haptable_servo& servo = room.fingers.servo[0] = before_;
        const haptable_freed& freed = room.freed[0] = freed_before_;
        const bool is_known = freed.tick == servo.counters.ticks && freed.contacts == servo.counters.contacts;
        if (smooth.energy == nullptr && is_known) servo.contact = freed.at;
        Eigen::Map<Eigen::Vector3f>(servo.contact.load_n) = (share * (last_.s * (now_.x - last_.god))).cast<float>();
        haptable_output out;
        haptable_servo_step(&smooth, &servo, Eigen::Vector3f(now_.x.cast<float>()).data(), 0, &out);
        return out.state == HAPTABLE_CONTACT && is_at(out.god_object_m);
    }

    bool is_at(const float god_object_m[3]) const {
        return (to_vector(god_object_m) - now_.god).norm() <= static_cast<double>(model_.tolerance_m);
    }

    /// A god-object that is where it would be without friction need not have its force in the cone: no point may. At a
    /// limit that depends on the last bit of the load, and is taken as the servo has it.
    bool is_freed() const {
        if (now_.has_limit) return is_at(freed()->at.god_object_m);
        return is_frictionless(1.0 + kLaw) || is_frictionless(1.0 - kLaw);
    }

    void check_cone() {
        if (now_.counters.contacts != last_.counters.contacts) return;
        const auto normal = touched_.on.solid.outward(now_.at.patch, now_.at.alpha);
        const bool slips = servo_.contact.slips != 0;
        const double mu = static_cast<double>(slips ? model_.kinetic_friction : model_.static_friction);
        tick_.expect(!normal || is_in_cone(mu, *normal) || is_freed(), Fault::kCone);
    }

    const Touched& touched_;
    const haptable_model& model_;
    SceneState& scene_;
    haptable_servo &servo_, before_{};
    haptable_freed freed_before_{};  ///< with friction
    std::size_t finger_;
    SceneTick& tick_;
    Whereabouts where_;
    double rounding_m_ = 0.0;  ///< of a god-object
    Tick last_, now_;
    /// What is remembered of the ticks before.
    struct Session {
        bool is_first = true, came_from_outside = false;
        bool is_free = false;  ///< clearly outside, without contact
        int outside_ticks = 0, deep_ticks = 0;
        std::size_t behind_ticks = 0;
        double owed_j = 0.0;  ///< that a release holds back
    } since_;
    Account account_;
};

using Fingers = std::deque<FingerTrial>;

/// The points that press in a tick, T: C_TT f_T = u_T, in double.
struct Pressing {
    std::vector<std::size_t> in;  ///< [n] points
    Eigen::VectorXd u_m, f_n;     ///< [3 n] dents and loads
    Eigen::MatrixXd c;            ///< [3 n, 3 n]
    double rounding_m = 0.0;

    Pressing() = default;
    Pressing(const Fingers& point, const Touched& touched) {
        std::vector<SurfacePoint> at;
        for (std::size_t i = 0; i < point.size(); ++i)
            if (point[i].now().presses) in.push_back(i), at.push_back(point[i].now().at);
        u_m = of_each(point, [](const auto& one) { return one.now().loaded_u(); });
        f_n = of_each(point, [](const auto& one) { return one.now().load_n; });
        for (const std::size_t i : in) rounding_m = std::max(rounding_m, point[i].rounding_m());
        if (!in.empty()) c = touched.on.law.compliance(touched.coupling(), at);
    }
    /// One below the other.
    template <typename Value>
    Eigen::VectorXd of_each(const Fingers& point, const Value& value) const {
        Eigen::VectorXd all(3 * static_cast<Eigen::Index>(in.size()));
        for (Eigen::Index k = 0; 3 * k < all.size(); ++k)
            all.segment<3>(3 * k) = value(point[in[static_cast<std::size_t>(k)]]);
        return all;
    }
    double stored_j() const { return 0.5 * u_m.dot(f_n); }
    /// The residual, as its size and the rounding of places allow: that does not ask for C's condition.
    bool is_law() const {
        if (in.empty()) return true;
        return (c * f_n - u_m).norm() <=
               kLaw * (c.norm() * f_n.norm() + u_m.norm()) + std::sqrt(in.size()) * rounding_m;
    }
    /// Where the points have gone, the god-objects standing still.
    double stored_at(const Fingers& point) const {
        const Eigen::VectorXd u = u_m + of_each(point, [](const auto& one) { return one.motion_m(); });
        return in.empty() ? 0.0 : 0.5 * u.dot(c.ldlt().solve(u));
    }
};

/// What hands do in a tick, and are given.
struct Hands {
    std::array<haptable_input, HAPTABLE_HANDS> in{};
    std::array<haptable_output, HAPTABLE_HANDS> out{};
    haptable_tool_output tool{};

    void step(const Touched& touched, SceneState& scene, const FingerPositions& at, std::size_t tick) {
        for (std::size_t f = 0; f < scene.fingers(); ++f) {
            std::copy_n(at[f].begin(), 3, in[f].finger_m);
            in[f].is_there = 1;
        }
        const std::uint32_t now_us = static_cast<std::uint32_t>(tick) * HAPTABLE_TICK_US;
        if (touched.tool() == nullptr) return touched.step(scene, in.data(), now_us, out.data());
        haptable_tool_input pose{in[0], {}};
        std::copy_n(turn_of(at[1]).begin(), 4, pose.turn);
        touched.step(scene, &pose.hand, now_us, &tool.hand);
    }
};

/// One stroke on one scene.
class Trial {
public:
    Trial(const Touched& touched, std::string* told)
        : touched_(touched),
          told_(told),
          scene_(touched.model, touched.pair, touched.body(), touched.modes(), touched.tool()),
          rigid_(touched.body() != nullptr ? rigid_of(*touched.body()) : Rigid()),
          ledger_(touched.on.servo().stiffness.felt_n_per_m, touched.body() != nullptr ? &rigid_ : nullptr,
                  touched.modes() != nullptr &&
                      (touched.model.energy == nullptr || touched.model.frictionless != nullptr)) {
        for (std::size_t f = 0; f < touched.contacts(); ++f) finger_.emplace_back(touched_, scene_, f, tick_);
    }

    Verdict run(const Stroke& stroke) {
        for (const FingerPositions& at : stroke) {
            step(at);
            const bool is_sound =
                std::ranges::all_of(finger_, [](const auto& finger) { return finger.now().felt.at_m.allFinite(); });
            is_sound ? check() : begin();
            for (auto& finger : finger_)
                if (told_ != nullptr && is_sound) *told_ += finger.describe(ledger_.risen_j());
            ++tick_.index;
        }
        for (const auto& finger : finger_) tick_.verdict.limits += finger.now().limits();
        return tick_.verdict;
    }

private:
    void step(const FingerPositions& at) {
        tick_.faults.clear();
        tick_.rests = tick_.index > 0 && at == at_;
        at_ = at;
        if (touched_.body() != nullptr) tick_.before = motion_of(*scene_.body(), rigid_);
        for (FingerTrial& finger : finger_) finger.keep();
        hands_ = Hands();
        hands_.step(touched_, scene_, at, static_cast<std::size_t>(tick_.index));
        if (touched_.body() != nullptr) tick_.after = motion_of(*scene_.body(), rigid_);
        for (std::size_t f = 0; f < finger_.size(); ++f)
            touched_.tool() != nullptr ? finger_[f].take() : finger_[f].take(hands_.in[f], hands_.out[f]);
        const bool was_sought = std::exchange(is_sought_, touched_.has_points() && scene_.points().sets > kSets);
        tick_.has_limit = was_sought || is_sought_ || std::ranges::any_of(finger_, &FingerTrial::has_limit);
    }

    void check() {
        for (auto& finger : finger_) finger.check();
        const auto contacts = std::ranges::count_if(finger_, [](const auto& finger) { return finger.now().contact; });
        tick_.verdict.contact_ticks += contacts > 0 ? 1 : 0;
        tick_.verdict.both_ticks += contacts > 1 ? 1 : 0;
        if (touched_.has_points()) check_points();
        if (touched_.body() != nullptr && !only_fingers_act()) return;
        if (touched_.body() != nullptr) check_momentum();
        if (touched_.body() != nullptr || touched_.modes() != nullptr ||
            (touched_.pair != nullptr && touched_.model.energy != nullptr && !touched_.has_points()))
            check_ledger();
    }

    void begin() {
        for (auto& finger : finger_) finger.begin();
        last_ = Pressing();
        unfelt_ticks_ = 0;
        account_.begin();
    }

    // ---- all points ----

    void check_points() {
        Pressing now(finger_, touched_);
        tick_.expect(now.is_law(), Fault::kLaw);
        if (touched_.tool() != nullptr) tick_.expect(is_wrench(now), Fault::kForce);
        if (touched_.model.energy != nullptr && !tick_.verdict.clamped) check_points_energy(now);
        check_unfelt(now.in.empty());
        last_ = std::move(now);
    }

    /// None presses, and has not for twice as many ticks as the servo waits, though one is deep inside.
    void check_unfelt(bool none_presses) {
        const bool is_deep = std::ranges::any_of(finger_, [&](const FingerTrial& one) {
            return one.now().contact && one.now().dent().dot(one.now().normal) < -kDeep * touched_.on.solid.size_m();
        });
        unfelt_ticks_ = is_deep && none_presses ? unfelt_ticks_ + 1 : 0;
        tick_.expect(unfelt_ticks_ < 2 * HAPTABLE_POINTS_UNFELT, Fault::kLost);
    }

    /// F = -sum f_i and M = -sum r_i x f_i, within their limits; one whose points fade has less.
    bool is_wrench(const Pressing& now) {
        const haptable_tool_output& out = hands_.tool;
        const double most_n = static_cast<double>(touched_.model.max_force_n);
        const double most_n_m = static_cast<double>(touched_.tool()->max_torque_n_m);
        const Vector3d force = to_vector(out.hand.force_n), torque = to_vector(out.torque_n_m);
        if (std::ranges::any_of(now.in, [&](std::size_t i) { return finger_[i].fades(); }))
            return force.norm() <= most_n * (1.0 + kLaw) && torque.norm() <= most_n_m * (1.0 + kLaw);
        const Vector3d handle = to_vector(out.position_m);
        Vector3d f = Vector3d::Zero(), m = f;
        double size = 0.0, arm = handle.norm();
        for (const std::size_t i : now.in) {
            const Vector3d load = finger_[i].now().load_n, r = finger_[i].now().x - handle;
            f -= load;
            m -= r.cross(load);
            size += load.norm();
            arm = std::max(arm, r.norm());
        }
        tick_.verdict.clamped |= f.norm() > most_n || m.norm() > most_n_m;
        return (force - cut(f, most_n)).norm() <= kLaw * size &&
               (torque - cut(m, most_n_m)).norm() <= kLaw * arm * size;
    }

    /// As of one finger: on the springs of the last tick. What begins to press the hand has pressed.
    void check_points_energy(const Pressing& now) {
        const double moved_j = last_.stored_at(finger_);
        const bool begins =
            !std::ranges::includes(last_.in, now.in) || std::ranges::any_of(finger_, &FingerTrial::may_begin);
        const double pressed_j = begins ? std::max(0.0, now.stored_j() - moved_j) : 0.0;
        tick_.expect(account_.note(last_.stored_j() - moved_j - pressed_j, now.stored_j(),
                                   now.f_n.norm() * now.rounding_m, tick_.verdict),
                     Fault::kEnergy);
    }

    // ---- a body that moves, or two fingers ----

    /// No weight, no suspension, no floor.
    bool only_fingers_act() const {
        const haptable_body& body = *touched_.body();
        float sum = static_cast<float>(body.point_count);
        for (int c = 0; c < 3; ++c)
            sum += std::abs(body.gravity_m_per_s2[c]) + body.stiffness_n_per_m[c] + body.damping_n_s_per_m[c] +
                   body.turn_stiffness_n_m[c] + body.turn_damping_n_m_s[c];
        return sum == 0.0F;
    }

    /// What acts on the body is its fingers alone.
    void check_momentum() {
        const Motion &before = tick_.before, &after = tick_.after;
        Vector3d linear = after.momentum - before.momentum, angular = after.spin_momentum - before.spin_momentum;
        double size = before.momentum.norm() + after.momentum.norm();
        double turning = before.spin_momentum.norm() + after.spin_momentum.norm();
        for (const auto& finger : finger_) {
            const Felt& felt = finger.now().felt;
            const Vector3d arm = felt.at_m - before.centre_m, impulse = -kTick_s * felt.force_n;
            linear -= impulse;
            angular -= arm.cross(impulse);
            size += impulse.norm();
            turning += (felt.at_m.norm() + before.centre_m.norm() + arm.norm()) * impulse.norm();
        }
        const double none = kTick_s * kNoForce_n;
        tick_.expect(linear.norm() <= kImpulse * kFloat * size + none &&
                         angular.norm() <= kImpulse * kFloat * turning + none * touched_.on.solid.reach_m(),
                     Fault::kMomentum);
    }

    /// Until a clamp is met: beyond it the force is no gradient. What a contact holds is left out, for not all of it is
    /// given.
    void check_ledger() {
        Verdict& verdict = tick_.verdict;
        if (verdict.clamped) return;
        const Tick &a = finger_.front().now(), &b = finger_.back().now();
        const std::array felt{a.felt, b.felt};
        const double contacts_j =
            touched_.pair != nullptr ? static_cast<double>(scene_.pair()->energy_j) : a.energy_j();
        Matrix6d together = Matrix6d::Zero();
        if (touched_.pair != nullptr && finger_.size() == 2 && a.contact && b.contact)
            together = std::max(a.largest_tangent(), b.largest_tangent()) *
                       touched_.on.law.stiffness_of_two(*touched_.pair, {a.at, b.at});
        ledger_.note(felt.data(), finger_.size(), modes_j(scene_), tick_.before, tick_.after, together);
        verdict.most_stored_j = std::max(verdict.most_stored_j, contacts_j + ledger_.largest_j());
        verdict.most_given_j = ledger_.risen_j();
        tick_.expect(ledger_.risen_j() <= kEnergy * verdict.most_stored_j + ledger_.rounded_j(), Fault::kEnergy);
    }

    const Touched& touched_;
    std::string* told_;
    SceneState scene_;
    SceneTick tick_;
    Rigid rigid_;
    Ledger ledger_;
    Fingers finger_;
    Hands hands_;
    Pressing last_;    ///< in the last tick
    Account account_;  ///< of all points
    int unfelt_ticks_ = 0;
    bool is_sought_ = false;  ///< who presses: the next tick goes on
    FingerPositions at_{};
};

// A hand that goes after a body is this far behind, in ticks.
constexpr double kBehind = 50.0;

}  // namespace

/// The hands' frame follows the body's.
Stroke make_stroke(const Touched& touched, std::uint64_t seed, std::uint64_t number) {
    if (touched.tool() != nullptr) return touched.on.maker.make_poses(seed, number);
    Stroke stroke = touched.on.maker.make(seed, number, touched.fingers());
    if (touched.body() == nullptr) return stroke;
    SceneState scene(touched.model, touched.pair, touched.body(), touched.modes());
    const Rigid rigid = rigid_of(*touched.body());
    Vector3d centre = rigid.centre_m;
    Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
    Hands hands;
    for (std::size_t i = 0; i < stroke.size(); ++i) {
        for (std::size_t f = 0; f < scene.fingers(); ++f) {
            const Vector3d at = turn * (to_vector(stroke[i][f].data()) - rigid.centre_m) + centre;
            std::copy_n(at.data(), 3, stroke[i][f].begin());
        }
        hands.step(touched, scene, stroke[i], i);
        const Motion motion = motion_of(*scene.body(), rigid);
        if (!motion.centre_m.allFinite() || !motion.turn.coeffs().allFinite()) continue;
        centre += (motion.centre_m - centre) / kBehind;
        turn = turn.slerp(1.0 / kBehind, motion.turn).normalized();
    }
    return stroke;
}

Verdict judge(const Touched& touched, const Stroke& stroke, std::string* told) {
    return Trial(touched, told).run(stroke);
}

}  // namespace haptable
