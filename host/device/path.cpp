// SPDX-License-Identifier: GPL-2.0-or-later
// s(t) = 10 t^3 - 15 t^4 + 6 t^5: a movement of minimum jerk, as hands make them
// (Flash and Hogan, J. Neuroscience 5(7), 1985), along straight lines and circles.
#include "host/device/path.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/base/command_line.hpp"
#include "host/base/error.hpp"
#include "host/base/turn.hpp"

namespace haptable {

namespace {

using Eigen::Vector3d;

// A movement of no length still takes this long, so that no velocity is infinite.
constexpr double kShortest_s = 0.02;

// Before it is lifted: a hand that has gripped feels so.
constexpr double kGrip_s = 0.1;

/// One movement: from `from` to `to` in a straight line, or once round `centre`.
struct Move {
    enum class Kind { line, circle } kind;
    double duration_s;
    Vector3d from_m;
    Vector3d to_m;      ///< of a line
    Vector3d centre_m;  ///< of a circle
    Vector3d normal;    ///< of a circle, of length 1: turned about, right-handed
    Vector3d turn_from = Vector3d::Zero(), turn_to = Vector3d::Zero();  ///< of a tool: rotation vectors, of one axis
};

/// Share of the way, and its rate, at a share tau of the time.
std::array<double, 2> minimum_jerk(double tau) {
    const double t = std::clamp(tau, 0.0, 1.0);
    return {t * t * t * (10.0 + t * (-15.0 + 6.0 * t)), 30.0 * t * t * (1.0 - t) * (1.0 - t)};
}

HandGoal on_move(const Move& move, double time_s) {
    const auto [share, rate] = minimum_jerk(time_s / move.duration_s);
    const double rate_per_s = rate / move.duration_s;
    const Vector3d turning = move.turn_to - move.turn_from;
    const Turning wrist{turned_by(move.turn_from + share * turning), rate_per_s * turning};
    if (move.kind == Move::Kind::line)
        return {move.from_m + share * (move.to_m - move.from_m), rate_per_s * (move.to_m - move.from_m), 0, wrist};
    const double turn = 2.0 * std::numbers::pi;
    const Vector3d arm = move.from_m - move.centre_m;
    const Vector3d side = move.normal.cross(arm);
    const double c = std::cos(turn * share), s = std::sin(turn * share);
    return {move.centre_m + c * arm + s * side, turn * rate_per_s * (c * side - s * arm), 0, wrist};
}

/// Movements one after the other, of a tool whose handle is `reach_m` above the place where it touches.
class Script : public Path {
public:
    Script(double speed_m_s, double reach_m, const Eigen::Quaterniond& upright)
        : speed_m_s_(speed_m_s), reach_m_(reach_m * (upright * Vector3d::UnitZ())), upright_(upright) {}

    void begin_at(const Vector3d& point_m) {
        if (moves_.empty())
            here_m_ = point_m;
        else
            line_to(point_m);
    }
    void line_to(const Vector3d& to_m) {
        const double time_s = std::max((to_m - here_m_).norm() / speed_m_s_, kShortest_s);
        add({Move::Kind::line, time_s, here_m_, to_m, Vector3d::Zero(), Vector3d::Zero()}, to_m);
    }
    void circle_about(const Vector3d& centre_m, const Vector3d& normal) {
        const double length_m = 2.0 * std::numbers::pi * (here_m_ - centre_m).norm();
        const double time_s = std::max(length_m / speed_m_s_, kShortest_s);
        add({Move::Kind::circle, time_s, here_m_, here_m_, centre_m, normal}, here_m_);
    }
    /// Turns the tool about the place where it touches, from as it is.
    void turn_to(const Vector3d& rotation_rad) {
        const double time_s = std::max((rotation_rad - turn_rad_).norm() / kTurning_rad_s, kShortest_s);
        Move move{Move::Kind::line, time_s, here_m_, here_m_, Vector3d::Zero(), Vector3d::Zero()};
        move.turn_from = turn_rad_;
        move.turn_to = turn_rad_ = rotation_rad;
        add(move, here_m_);
    }
    void hold(double time_s) {
        add({Move::Kind::line, std::max(time_s, kShortest_s), here_m_, here_m_, Vector3d::Zero(), Vector3d::Zero()},
            here_m_);
    }

    double duration_s() const override { return duration_s_; }
    HandGoal at(double time_s) const override {
        double left_s = std::clamp(time_s, 0.0, duration_s_);
        for (const Move& move : moves_) {
            if (left_s <= move.duration_s) return of_handle(on_move(move, left_s));
            left_s -= move.duration_s;
        }
        return of_handle({here_m_, Vector3d::Zero(), 0, {turned_by(turn_rad_), Vector3d::Zero()}});
    }

private:
    static constexpr double kTurning_rad_s = 0.5;

    /// From the place that touches to the handle.
    HandGoal of_handle(HandGoal goal) const {
        const Vector3d reach_m = goal.wrist.turn * reach_m_;
        goal.position_m += reach_m;
        goal.velocity_m_s += goal.wrist.spin_rad_s.cross(reach_m);
        goal.wrist.turn = goal.wrist.turn * upright_;
        return goal;
    }
    void add(const Move& move, const Vector3d& end_m) {
        moves_.push_back(move);
        duration_s_ += move.duration_s;
        here_m_ = end_m;
    }

    double speed_m_s_;
    Vector3d reach_m_;
    Eigen::Quaterniond upright_;  ///< the tool's -z into the body
    std::vector<Move> moves_;
    Vector3d here_m_ = Vector3d::Zero();
    Vector3d turn_rad_ = Vector3d::Zero();
    double duration_s_ = 0.0;
};

class Recording : public Path {
public:
    explicit Recording(std::vector<FingerTick> ticks) : ticks_(std::move(ticks)) {}

    double duration_s() const override { return kStep_s * static_cast<double>(ticks_.size()); }
    HandGoal at(double time_s) const override {
        const double last = static_cast<double>(ticks_.size() - 1);
        const double place = std::clamp(time_s / kStep_s, 0.0, last);
        const Vector3d from_m = point_m(std::floor(place));
        const Vector3d to_m = point_m(std::min(std::floor(place) + 1.0, last));
        const Eigen::Quaterniond from = turn(std::floor(place)), to = turn(std::min(std::floor(place) + 1.0, last));
        const Vector3d turning = rotation_vector(to * from.conjugate());
        return {from_m + (place - std::floor(place)) * (to_m - from_m),
                (to_m - from_m) / kStep_s,
                ticks_[static_cast<std::size_t>(place)].buttons,
                {turned_by((place - std::floor(place)) * turning) * from, turning / kStep_s}};
    }

private:
    static constexpr double kStep_s = 1e-3;

    Vector3d point_m(double index) const { return Vector3d(ticks_[static_cast<std::size_t>(index)].position_m.data()); }

    Eigen::Quaterniond turn(double index) const {
        const auto& turn = ticks_[static_cast<std::size_t>(index)].turn;
        if (!turn) return Eigen::Quaterniond::Identity();
        return Eigen::Quaterniond((*turn)[0], (*turn)[1], (*turn)[2], (*turn)[3]).normalized();
    }

    std::vector<FingerTick> ticks_;
};

/// The way into the body and two directions along its surface, each of length 1 and at right angles.
struct Frame {
    Vector3d into, along, across;
};

Frame frame_of(const PathOptions& o) {
    if (!(o.direction.norm() > 0.0))
        throw BadCommandLine("--direction: is zero: give the way into the body, such as 0,0,-1");
    const Vector3d into = o.direction.normalized();
    // Unless asked otherwise: the coordinate axis that lies flattest on the surface.
    Vector3d wanted = o.along;
    if (wanted.isZero()) {
        Eigen::Index flattest = 0;
        into.cwiseAbs().minCoeff(&flattest);
        wanted = Vector3d::Unit(flattest);
    }
    const Vector3d flat = wanted - into.dot(wanted) * into;
    if (flat.norm() <= 1e-9 * wanted.norm())
        throw BadCommandLine("--along: is parallel to --direction: give a way along the surface");
    return {into, flat.normalized(), into.cross(flat.normalized())};
}

void add_poke(const PathOptions& o, const Frame& frame, Script& script) {
    const Vector3d above_m = o.at_m - o.clearance_m * frame.into;
    script.begin_at(above_m);
    script.line_to(o.at_m + o.depth_m * frame.into);
    script.hold(o.hold_s);
    script.line_to(above_m);
}

void add_drag(const PathOptions& o, const Frame& frame, Script& script) {
    const Vector3d above_m = o.at_m - o.clearance_m * frame.into;
    const Vector3d below_m = o.at_m + o.depth_m * frame.into;
    script.begin_at(above_m);
    script.line_to(below_m);
    script.line_to(below_m + o.radius_m * frame.along);
    script.line_to(below_m - o.radius_m * frame.along);
    script.line_to(below_m);
    script.line_to(above_m);
}

void add_circle(const PathOptions& o, const Frame& frame, Script& script) {
    const Vector3d rim_m = o.at_m + o.radius_m * frame.along;
    script.begin_at(rim_m - o.clearance_m * frame.into);
    script.line_to(rim_m + o.depth_m * frame.into);
    script.circle_about(o.at_m + o.depth_m * frame.into, -frame.into);
    script.line_to(rim_m - o.clearance_m * frame.into);
}

void add_lift(const PathOptions& o, const Frame& frame, Script& script) {
    const Vector3d beside_m = o.at_m - o.clearance_m * frame.into, in_m = o.at_m + o.depth_m * frame.into;
    const Vector3d up_m = in_m + o.lift_m * Vector3d::UnitZ();
    script.begin_at(beside_m);
    script.line_to(in_m);
    script.hold(kGrip_s);
    script.line_to(up_m);
    script.hold(o.hold_s);
    script.line_to(in_m);
    script.line_to(beside_m);
}

/// axis: of length 1, that the tool is turned about.
void add_turns(const PathOptions& o, const Frame& frame, const Vector3d& axis, Script& script) {
    const Vector3d above_m = o.at_m - o.clearance_m * frame.into, most = o.turn_deg * std::numbers::pi / 180.0 * axis;
    script.begin_at(above_m);
    script.line_to(o.at_m + o.depth_m * frame.into);
    script.turn_to(most);
    script.turn_to(-most);
    script.turn_to(Vector3d::Zero());
    script.line_to(above_m);
}

void add_named(const std::string& name, const PathOptions& o, const Frame& frame, Script& script) {
    if (name == "poke")
        add_poke(o, frame, script);
    else if (name == "drag")
        add_drag(o, frame, script);
    else if (name == "circle")
        add_circle(o, frame, script);
    else if (name == "lift")
        add_lift(o, frame, script);
    else if (name == "roll")
        add_turns(o, frame, frame.along, script);
    else if (name == "tilt")
        add_turns(o, frame, frame.across, script);
    else
        throw BadCommandLine(
            "--path: \"" + name +
            "\" is not known: it is poke, drag, circle, lift, roll, tilt, or a file whose name ends in .csv");
}

}  // namespace

std::unique_ptr<Path> scripted_path(const std::string& names, const PathOptions& options) {
    if (!(options.speed_m_s > 0.0)) throw BadCommandLine("--speed: must be greater than 0 m/s");
    const Frame frame = frame_of(options);
    auto script = std::make_unique<Script>(options.speed_m_s, options.reach_m, turn_from_z(Vector3d(-frame.into)));
    for (std::size_t begin = 0; begin <= names.size();) {
        const std::size_t comma = std::min(names.find(',', begin), names.size());
        add_named(names.substr(begin, comma - begin), options, frame, *script);
        begin = comma + 1;
    }
    return script;
}

std::vector<FingerTick> ticks_of(const std::vector<FingerTick>& ticks, std::size_t finger) {
    std::vector<FingerTick> its;
    for (const FingerTick& tick : ticks) {
        if (finger >= tick.fingers() || tick.finger(finger).is_away) continue;
        its.push_back(tick);
        static_cast<FingerPlace&>(its.back()) = tick.finger(finger);
    }
    return its;
}

std::unique_ptr<Path> recorded_path(std::vector<FingerTick> ticks) {
    if (ticks.empty())
        throw Error("--path: the file has no positions: it needs one line x,y,z a millisecond, or x,y,z,x2,y2,z2");
    return std::make_unique<Recording>(std::move(ticks));
}

}  // namespace haptable
