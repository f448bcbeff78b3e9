// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/strokes/judge.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

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
constexpr double kLaw = 1e-4;
// Roundings of a float of size 1 that a god-object's coordinates, and their difference to the finger, may have.
constexpr double kRoundings = 8.0 * 0x1p-24;
constexpr double kEnergy = 1e-3;
// The arccosine that weighs normals at vertices is good to 7e-5; 3 of them for the two legs and the sum.
constexpr double kCone = 1e-3;

Vector3d vector_of(const float x[3]) {
    return {static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])};
}

/// Ascending.
Vector3d eigenvalues(const Matrix3d& s) {
    return Eigen::SelfAdjointEigenSolver<Matrix3d>(s, Eigen::EigenvaluesOnly).eigenvalues();
}

Vector3d cut(const Vector3d& force_n, double most_n) {
    const double size = force_n.norm();
    return size > most_n ? Vector3d(most_n / size * force_n) : force_n;
}

/// What one tick gave, and what it should have.
struct Tick {
    Vector3d x = Vector3d::Zero();
    bool contact = false;
    SurfacePoint at;
    Vector3d god = Vector3d::Zero();
    Matrix3d s = Matrix3d::Zero();        ///< S(god), from the tables
    Vector3d load_n = Vector3d::Zero();   ///< S u
    Vector3d law_n = Vector3d::Zero();    ///< -S u, cut to max_force
    Vector3d force_n = Vector3d::Zero();  ///< what the user felt
    std::array<Vector3d, 3> nodal_n{};    ///< as the servo published them
    haptable_counters counters{};

    Vector3d u() const { return x - god; }
    /// Energy of the spring that the contact is while the god-object stands still.
    double energy_at(const Vector3d& finger) const {
        return contact ? 0.5 * (finger - god).dot(s * (finger - god)) : 0.0;
    }
    double energy_j() const { return energy_at(x); }
    Vector3d released_n() const { return force_n - law_n; }
};

/// One stroke on one servo.
class Trial {
public:
    Trial(const Touched& touched, std::vector<Judged>* ticks)
        : ticks_(ticks),
          touched_(touched),
          model_(touched.model),
          where_(touched.solid),
          size_m_(touched.solid.size_m()),
          rounding_m_(kRoundings * touched.solid.reach_m()) {
        haptable_servo_init(&servo_);
    }
    Trial(const Trial&) = delete;
    Trial& operator=(const Trial&) = delete;

    Verdict run(const Stroke& stroke) {
        for (const auto& finger : stroke) {
            step(finger.data());
            if (!now_.x.allFinite()) {  // refused: the next one begins a session
                begin();
                continue;
            }
            verdict_.clamped |= is_cut(now_.load_n) || is_cut(now_.force_n);
            check_force();
            check_sides();
            if (now_.contact) check_law();
            if (!is_first_) check_change();
            if (model_.energy != nullptr) check_energy();
            if (model_.frictionless != nullptr && now_.contact && last_.contact) check_cone(finger.data());
            verdict_.contact_ticks += now_.contact ? 1 : 0;
            if (ticks_ != nullptr) ticks_->push_back(describe());
            faults_.clear();
            ++index_;
            is_first_ = false;
        }
        verdict_.counters = servo_.counters;
        return verdict_;
    }

private:
    void begin() {
        if (now_.force_n.norm() != 0.0) fault(Fault::kForce);
        if (ticks_ != nullptr) ticks_->push_back({});
        last_ = now_ = Tick();
        is_first_ = true;
        came_from_outside_ = is_free_ = had_limit_ = false;
        outside_ticks_ = deep_ticks_ = 0;
        behind_ticks_ = 0;
        given_j_ = held_j_ = owed_j_ = 0.0;
        ++index_;
    }

    void fault(Fault kind) {
        int& tick = verdict_.tick[static_cast<std::size_t>(kind)];
        if (tick < 0) tick = index_;
        faults_ += (faults_.empty() ? "" : " ") + std::string(name_of(kind));
    }

    Judged describe() {
        return {now_.contact,
                where_.is_inside(now_.x),
                now_.contact && sees_god(),
                now_.at,
                now_.god,
                std::size_t{now_.counters.walk_limits} + now_.counters.slide_limits + now_.counters.box_limits,
                touched_.solid.gap_m(now_.x),
                now_.force_n.norm(),
                now_.law_n.norm(),
                (now_.force_n - last_.force_n).norm(),
                now_.energy_j(),
                given_j_,
                faults_};
    }

    void step(const float finger_m[3]) {
        haptable_output out;
        before_ = servo_;
        freed_before_ = freed_;
        last_ = now_;
        touched_.step(&model_, &servo_, finger_m, static_cast<std::uint32_t>(index_) * 1000U, &out);
        now_ = Tick();
        now_.x = vector_of(finger_m);
        now_.force_n = vector_of(out.force_n);
        now_.counters = servo_.counters;
        now_.contact = out.state == HAPTABLE_CONTACT;
        if (!now_.contact) return;
        now_.at = {out.patch, vector_of(out.alpha)};
        now_.god = vector_of(out.god_object_m);
        now_.s = touched_.law.stiffness(now_.at);
        now_.load_n = now_.s * now_.u();
        now_.law_n = cut(-now_.load_n, static_cast<double>(model_.max_force_n));
        for (std::size_t c = 0; c < 3; ++c) now_.nodal_n[c] = vector_of(out.nodal_force_n[c]);
    }

    bool has_limit() const {
        const haptable_counters &a = last_.counters, &b = now_.counters;
        return b.walk_limits != a.walk_limits || b.slide_limits != a.slide_limits || b.box_limits != a.box_limits;
    }

    // ---- inside and outside ----

    /// The last motion was clearly inside midway from where it went in to where it came out; one that only touches an
    /// edge was not.
    bool went_through() const {
        const Solid& solid = touched_.solid;
        if (solid.sees(last_.x, now_.x)) return false;
        const auto from_last = [&](const Solid::Entry& entry) { return (entry.point_m - last_.x).norm(); };
        const std::vector<Solid::Entry> out = solid.entries(now_.x, last_.x, 0.0);
        for (const Solid::Entry& in : solid.entries(last_.x, now_.x, 0.0)) {
            double to_m = (now_.x - last_.x).norm();
            for (const Solid::Entry& one : out)
                if (from_last(one) > from_last(in)) to_m = std::min(to_m, from_last(one));
            const Vector3d middle = last_.x + 0.5 * (from_last(in) + to_m) * (now_.x - last_.x).normalized();
            if (solid.holds(middle) && solid.gap_m(middle) > kClear * size_m_) return true;
        }
        return false;
    }

    bool is_clearly_outside() { return !where_.is_inside(now_.x) && where_.is_beyond(now_.x, kClear * size_m_); }

    /// The finger is outside and sees the god-object, which lies on the surface within the servo's tolerance. No more
    /// of the line to it is left out: a wedge may be thinner.
    bool sees_god() {
        if (!is_clearly_outside()) return false;
        const Vector3d line = now_.x - now_.god;
        const double left_out_m = static_cast<double>(model_.tolerance_m);
        return touched_.solid.sees(now_.x, now_.god + std::min(0.5, left_out_m / line.norm()) * line);
    }

    void check_sides() {
        if (now_.contact) {
            came_from_outside_ = true;
            deep_ticks_ = 0;
            is_free_ = false;
            const bool sees = sees_god();
            outside_ticks_ = sees ? outside_ticks_ + 1 : 0;
            if (outside_ticks_ > (has_limit() || had_limit_ ? kLimitTicks : 0)) fault(Fault::kOutside);
            behind_ticks_ = !sees && is_clearly_outside() ? behind_ticks_ + 1 : 0;
            verdict_.most_behind_ticks = std::max(verdict_.most_behind_ticks, behind_ticks_);
            return;
        }
        outside_ticks_ = 0;
        behind_ticks_ = 0;
        const bool inside = where_.is_inside(now_.x), was_free = is_free_;
        is_free_ = is_clearly_outside();
        came_from_outside_ |= is_free_;
        if (was_free && is_free_ && !where_.is_beyond(now_.x, (now_.x - last_.x).norm()))
            verdict_.passed += went_through() ? 1 : 0;
        deep_ticks_ = inside && came_from_outside_ && where_.is_beyond(now_.x, kDeep * size_m_) ? deep_ticks_ + 1 : 0;
        if (deep_ticks_ >= kDeepTicks) fault(Fault::kLost);
    }

    // ---- the force ----

    void check_force() {
        if (!(now_.force_n.norm() <= static_cast<double>(model_.max_force_n) * (1.0 + 1e-5))) fault(Fault::kForce);
    }

    void check_law() {
        double largest = now_.load_n.norm();
        for (const Vector3d& nodal : now_.nodal_n) largest = std::max(largest, nodal.norm());
        double error = 0.0;
        for (int c = 0; c < 3; ++c)
            error = std::max(error, (now_.nodal_n[static_cast<std::size_t>(c)] -
                                     touched_.law.nodal_force(now_.at, now_.s, now_.u(), c))
                                        .norm());
        if (model_.release == nullptr) error = std::max(error, (now_.force_n - now_.law_n).norm());
        if (!(error <= kLaw * largest) && !(error <= rounding_of(largest))) fault(Fault::kLaw);
        if (!touched_.law.draws(now_.at)) return;
        const double gap_m = (touched_.law.drawn(now_.at, now_.nodal_n) - now_.u()).norm();
        if (gap_m <= kLaw * now_.u().norm()) return;
        if (!(gap_m <= rounding_of(now_.load_n.norm()) / eigenvalues(now_.s)[0])) fault(Fault::kDrawn);
    }

    /// The error that a force may have by the rounding of the god-object's coordinates and of the blocks.
    double rounding_of(double force_n) const {
        const Vector3d e = eigenvalues(now_.s);
        return e[2] * rounding_m_ + std::max(kLaw, kRoundings * e[2] / e[0]) * force_n;
    }

    // ---- from tick to tick ----

    bool is_cut(const Vector3d& force_n) const {
        return force_n.norm() >= static_cast<double>(model_.max_force_n) * (1.0 - 1e-5);
    }

    void check_change() {
        const Vector3d motion = now_.x - last_.x, change = now_.force_n - last_.force_n;
        if (model_.release == nullptr)
            check_rest(motion, change);
        else if (!is_cut(last_.force_n) && !is_cut(now_.force_n))
            check_jump(motion, change);
        owed_j_ = now_.contact ? std::max(0.0, owed_j_ + now_.released_n().dot(motion)) : 0.0;
        had_limit_ = has_limit();
    }

    /// Without release jumps are given as they are: but none where the finger rests.
    void check_rest(const Vector3d& motion, const Vector3d& change) {
        if (motion.norm() != 0.0 || has_limit() || had_limit_) return;
        const double rounded = now_.contact ? rounding_of(0.0) : 0.0;
        if (change.norm() > 1e-6 * now_.force_n.norm() + rounded) fault(Fault::kJump);
    }

    /// With release a force changes by a spring's change over the motion, of twice the stiffness, and by the release.
    /// Along the motion what pushed may end at once, of the contact's force and of what is being released.
    void check_jump(const Vector3d& motion, const Vector3d& change) {
        double slack =
            2.0 * static_cast<double>(model_.release_n) + kLaw * (now_.force_n.norm() + last_.force_n.norm());
        if (change.norm() <= slack) return;
        if (now_.contact) slack += 2.0 * eigenvalues(now_.s)[2] * (motion.norm() + rounding_m_);
        const Vector3d w = motion.norm() > 0.0 ? Vector3d(motion.normalized()) : Vector3d(Vector3d::Zero());
        const double along = std::min(0.0, change.dot(w));
        const double pushed = std::max(0.0, last_.law_n.dot(w)) + std::max(0.0, last_.released_n().dot(w));
        const double brakes = std::max(0.0, -now_.law_n.dot(w)), ends = slack + pushed + taken_back(motion, pushed);
        if ((change - along * w).norm() > slack || -along > ends + brakes)
            fault(Fault::kJump);
        else if (-along > ends)
            fault(Fault::kBrake);
    }

    /// What a release held back of forces that brake was not paid, and may be taken back: a force that pushed may turn
    /// into one that brakes as much.
    double taken_back(const Vector3d& motion, double pushed) const {
        return pushed > 0.0 ? std::min(pushed, owed_j_ / motion.norm()) : 0.0;
    }

    // ---- energy ----

    /// What the finger did on a spring at the place where it came through the surface to a new contact.
    double work_of_entry() {
        if (!now_.contact || (last_.contact && now_.counters.contacts == last_.counters.contacts)) return 0.0;
        // A motion may begin within the tolerance behind the surface, and go along it there.
        const Vector3d from = last_.x - kClear * size_m_ * (now_.x - last_.x).normalized();
        std::vector<Solid::Entry> entries = touched_.solid.entries(from, now_.x, kClear * size_m_);
        if (entries.empty() && !where_.is_beyond(last_.x, kClear * size_m_))
            entries.push_back(touched_.solid.nearest(last_.x));
        double most = 0.0;
        for (const Solid::Entry& entry : entries)
            most = std::max(most, 0.5 * (now_.x - entry.point_m).dot(spring_at(entry) * (now_.x - entry.point_m)));
        return most;
    }

    Matrix3d spring_at(const Solid::Entry& entry) const {
        std::array<Vector3d, 3> v;
        for (std::size_t c = 0; c < 3; ++c)
            v[c] = vector_of(touched_.servo.vertex_m[touched_.servo.patch[entry.triangle][c]].data());
        const Vector3d n = (v[1] - v[0]).cross(v[2] - v[0]);
        SurfacePoint at{entry.triangle, Vector3d::Zero()};
        for (int c = 0; c < 3; ++c) {
            const Vector3d &a = v[static_cast<std::size_t>((c + 1) % 3)], &b = v[static_cast<std::size_t>((c + 2) % 3)];
            at.alpha[c] = std::max(0.0, n.dot((b - a).cross(entry.point_m - a)) / n.squaredNorm());
        }
        at.alpha /= at.alpha.sum();
        return touched_.law.stiffness(at);
    }

    /// What the last tick's contact gives until now, the god-object standing still; where it has ended, until that gave
    /// most.
    double given_by_spring() const {
        if (!last_.contact) return 0.0;
        if (now_.contact) return last_.energy_j() - last_.energy_at(now_.x);
        const Vector3d motion = now_.x - last_.x;
        const double curvature = motion.dot(last_.s * motion), slope = motion.dot(last_.load_n);
        const double fraction = curvature > 0.0 ? std::clamp(-slope / curvature, 0.0, 1.0) : 0.0;
        return last_.energy_j() - last_.energy_at(last_.x + fraction * motion);
    }

    /// Until a clamp is met: beyond it the force is no gradient.
    void check_energy() {
        if (verdict_.clamped) return;
        if (index_ > 0) given_j_ += given_by_spring() - work_of_entry() + now_.released_n().dot(now_.x - last_.x);
        const double stored = now_.energy_j();
        verdict_.most_stored_j = std::max(verdict_.most_stored_j, stored);
        rounding_j_ = std::max(rounding_j_, now_.load_n.norm() * rounding_m_);
        held_j_ = std::min(held_j_, given_j_ + stored);
        verdict_.most_given_j = std::max(verdict_.most_given_j, given_j_ - held_j_);
        if (given_j_ - held_j_ > kEnergy * verdict_.most_stored_j + rounding_j_) fault(Fault::kEnergy);
    }

    // ---- friction ----

    bool is_in_cone(double mu, const Vector3d& normal) const {
        const double pressed = -normal.dot(now_.load_n);
        const double along = (now_.load_n + pressed * normal).norm();
        return along <= mu * pressed + kCone * (1.0 + mu) * now_.load_n.norm() + rounding_of(0.0);
    }

    /// Where the god-object would be without friction, its force is anywhere. Least energy goes on from there as long
    /// as that stores no more than where it was held, whose load is `share` of what the tables say.
    bool is_frictionless(const float finger_m[3], double share) const {
        haptable_model smooth = model_;
        smooth.god_object = model_.frictionless;
        haptable_room room{};
        haptable_servo& servo = room.fingers.servo[0] = before_;
        const haptable_freed& freed = room.freed[0] = freed_before_;
        const bool is_known = freed.tick == servo.counters.ticks && freed.contacts == servo.counters.contacts;
        if (smooth.energy == nullptr && is_known) servo.contact = freed.at;
        const Vector3d held_n = share * (last_.s * (now_.x - last_.god));
        for (int c = 0; c < 3; ++c) servo.contact.load_n[c] = static_cast<float>(held_n[c]);
        haptable_output out;
        touched_.step(&smooth, &servo, finger_m, 0, &out);
        return out.state == HAPTABLE_CONTACT && is_at(out.god_object_m);
    }

    bool is_at(const float god_object_m[3]) const {
        return (vector_of(god_object_m) - now_.god).norm() <= static_cast<double>(model_.tolerance_m);
    }

    /// A god-object that is where it would be without friction need not have its force in the cone: no point may. At a
    /// limit that depends on the last bit of the load, and is taken as the servo has it.
    bool is_freed(const float finger_m[3]) const {
        if (has_limit()) return is_at(freed_.at.god_object_m);
        return is_frictionless(finger_m, 1.0 + kLaw) || is_frictionless(finger_m, 1.0 - kLaw);
    }

    void check_cone(const float finger_m[3]) {
        if (now_.counters.contacts != last_.counters.contacts) return;
        const auto normal = touched_.solid.outward(now_.at.patch, now_.at.alpha);
        const bool slips = servo_.contact.slips != 0;
        const double mu = static_cast<double>(slips ? model_.kinetic_friction : model_.static_friction);
        if (normal && !is_in_cone(mu, *normal) && !is_freed(finger_m)) fault(Fault::kCone);
    }

    std::vector<Judged>* ticks_;
    std::string faults_;  ///< of this tick
    const Touched& touched_;
    haptable_model model_;
    haptable_room room_{};
    haptable_servo &servo_ = room_.fingers.servo[0], before_{};
    haptable_freed &freed_ = room_.freed[0], freed_before_{};  ///< with friction
    Whereabouts where_;
    double size_m_;
    double rounding_m_;  ///< of a god-object
    int index_ = 0;
    Tick last_, now_;
    bool is_first_ = true, came_from_outside_ = false, had_limit_ = false;
    int outside_ticks_ = 0, deep_ticks_ = 0;
    bool is_free_ = false;  ///< clearly outside, without contact
    std::size_t behind_ticks_ = 0;
    double given_j_ = 0.0, held_j_ = 0.0, rounding_j_ = 0.0, owed_j_ = 0.0;
    Verdict verdict_;
};

}  // namespace

bool Verdict::is_clean() const {
    return std::all_of(tick.begin(), tick.end(), [](int first) { return first < 0; });
}

Verdict judge(const Touched& touched, const Stroke& stroke, std::vector<Judged>* ticks) {
    return Trial(touched, ticks).run(stroke);
}

}  // namespace haptable
