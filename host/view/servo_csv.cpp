// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/servo_csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string_view>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/text.hpp"

namespace haptable {

namespace {

constexpr std::string_view kHeader =
    "tick,x,y,z,contact,node_i,node_j,node_k,alpha_i,alpha_j,alpha_k,god_x,god_y,god_z,force_x,force_y,force_z";
constexpr std::size_t kColumns = 17;  // a file may have more behind them
// Columns of a body that nothing holds, in the last columns.
constexpr std::string_view kPoseColumns = ",body_x,body_y,body_z,turn_w,turn_x,turn_y,turn_z";
constexpr std::size_t kPose = 7;
// Columns of a second finger, behind the first's and its buttons, state and faults; of each other one behind it.
constexpr std::size_t kSecond = 20, kOther = 19;
// Columns of a tool: where it is drawn, then each point's contact as a finger's.
constexpr std::string_view kToolColumns = ",tool_x,tool_y,tool_z,tool_qw,tool_qx,tool_qy,tool_qz";
constexpr std::size_t kPointColumns = 13;
constexpr double kTick_s = 0.001;
// The servo computes area coordinates in single precision: they may miss 0, 1 and the sum 1 by some of its last digits.
constexpr double kAlphaSlack = 1e-4;

/// What a row says of one finger.
struct Finger {
    bool contact = false;
    PatchNodes node{};
    std::array<double, 3> finger_m{}, alpha{}, god_object_m{}, force_n{};
};

struct Row {
    std::int64_t tick = 0;
    Finger first;
    std::vector<Finger> others;  ///< that are there
    std::array<double, kPose> pose{}, tool{};
    std::vector<Finger> points;  ///< of a tool, those that touch
    std::vector<float> modes;
};

bool finite(const std::array<double, 3>& v) {
    return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

Eigen::Vector3d vector(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

class Reader {
public:
    Reader(const std::filesystem::path& file, const ContactLoads& loads) : file_(file), loads_(loads) {}

    std::vector<ContactFrame> read(const FrameChoice& choice) {
        const std::string text = read_text(file_);
        std::string_view rest = text;
        const std::string_view header = next_line(rest);
        columns_ = static_cast<std::size_t>(std::count(header.begin(), header.end(), ',')) + 1;
        const std::string_view more = header.substr(std::min(kHeader.size(), header.size()));
        for (others_ = 0;
             header.find(fmt::format(",x{0},y{0},z{0},contact{0},", others_ + 2)) != std::string_view::npos;)
            ++others_;
        if (!header.starts_with(kHeader) || !(more.empty() || more.front() == ',') ||
            (others_ > 0 && columns_ < kSecond + kOther * others_))
            fail(
                "the header is not the one of a servo's CSV: it begins with tick,x,y,z,contact; give the file that "
                "servo --replay IN --out OUT wrote");
        has_pose_ = header.ends_with(kPoseColumns);
        if (const std::size_t at = header.find(kToolColumns); at != std::string_view::npos)
            tool_ = static_cast<std::size_t>(
                std::count(header.begin(), header.begin() + static_cast<std::ptrdiff_t>(at) + 1, ','));
        for (std::size_t at = 0; (at = header.find(",contact_p", at)) != std::string_view::npos; ++at) ++points_;
        if (points_ > 0 && (tool_ == 0 || tool_ + kPose + kPointColumns * points_ > columns_))
            fail("the header's columns of a tool are not a servo's: make the file again with the servo");
        for (std::size_t at = 0; (at = header.find(",mode_", at)) != std::string_view::npos; ++at) ++modes_;
        std::vector<ContactFrame> frames;
        std::size_t rows = 0;
        std::set<std::int64_t> wanted(choice.ticks.begin(), choice.ticks.end());
        std::int64_t last = -1;
        while (!rest.empty()) {
            const Row row = parse(next_line(rest));
            if (row.tick <= last) fail(fmt::format("tick {} comes after tick {}: ticks must rise", row.tick, last));
            check(row.first);
            if (rows == 0) rest_ = row.pose;
            last = row.tick;
            const bool chosen = choice.ticks.empty() ? static_cast<std::int64_t>(rows) % choice.every_ms == 0
                                                     : wanted.erase(row.tick) == 1;
            if (chosen) frames.push_back(frame(row));
            ++rows;
        }
        if (rows == 0) throw Error(file_.string() + ": holds a header and no tick: nothing to draw");
        if (!wanted.empty())
            throw Error(fmt::format("{}: has no tick {}: it ends with {}", file_.string(), *wanted.begin(), last));
        return frames;
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        throw Error(fmt::format("{}:{}: {}", file_.string(), line_, what));
    }

    std::string_view next_line(std::string_view& rest) {
        ++line_;
        const std::size_t end = rest.find('\n');
        std::string_view line = rest.substr(0, end);
        rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
        if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
        return line;
    }

    template <typename Number>
    Number number(std::string_view field, const char* column) const {
        Number value{};
        if (!read_number(field, value))
            fail(fmt::format("{} is \"{}\", which is no number: make the file again with the servo", column,
                             field.substr(0, 40)));
        return value;
    }

    Row parse(std::string_view line) const {
        const std::vector<std::string> field = split(line, ',');
        if (field.size() != columns_)
            fail(fmt::format("has {} columns where {} belong: is the file cut off?", field.size(), columns_));
        Row row;
        row.tick = number<std::int64_t>(field[0], "tick");
        const int contact = number<int>(field[4], "contact");
        if (contact != 0 && contact != 1) fail(fmt::format("contact is {}: it must be 0 or 1", contact));
        row.first = finger(field, 1, contact == 1);
        for (std::size_t i = 0; i < others_; ++i)
            if (const auto at = other(field, i)) row.others.push_back(*at);
        const std::size_t pose = columns_ - (has_pose_ ? kPose : 0), modes = pose - modes_;
        for (std::size_t k = modes; k < pose; ++k) row.modes.push_back(number<float>(field[k], "a mode"));
        for (std::size_t k = pose; k < columns_; ++k) row.pose[k - pose] = number<double>(field[k], "the body's place");
        if (tool_ > 0) read_tool(field, row);
        return row;
    }

    void read_tool(const std::vector<std::string>& field, Row& row) const {
        for (std::size_t k = 0; k < kPose; ++k) row.tool[k] = number<double>(field[tool_ + k], "the tool's place");
        for (std::size_t i = 0; i < points_; ++i) {
            const std::size_t contact = tool_ + kPose + kPointColumns * i;
            if (number<int>(field[contact], "a point's contact") == 0) continue;
            // As a finger's but for its position, whose columns are another one's.
            row.points.push_back(finger(field, contact - 3, true));
            row.points.back().finger_m = row.points.back().god_object_m;
            check(row.points.back());
        }
    }

    /// x: the column of the finger's position, which the others of a finger follow.
    Finger finger(const std::vector<std::string>& field, std::size_t x, bool contact) const {
        Finger finger;
        finger.contact = contact;
        for (std::size_t i = 0; i < 3; ++i) {
            finger.finger_m[i] = number<double>(field[x + i], "the finger's position");
            finger.node[i] = number<std::int32_t>(field[x + 4 + i], "a node");
            finger.alpha[i] = number<double>(field[x + 7 + i], "an area coordinate");
            finger.god_object_m[i] = number<double>(field[x + 10 + i], "the god-object's position");
            finger.force_n[i] = number<double>(field[x + 13 + i], "the force");
        }
        return finger;
    }

    /// None: finger i + 2 is not there in this tick.
    std::optional<Finger> other(const std::vector<std::string>& field, std::size_t i) const {
        const std::size_t x = kSecond + kOther * i;
        const Finger other = finger(field, x, number<int>(field[x + 3], "a contact") == 1);
        if (!other.contact) return finite(other.finger_m) ? std::optional(other) : std::nullopt;
        if (!loads_.is_patch(other.node) || !finite(other.finger_m) || !finite(other.god_object_m) ||
            !finite(other.alpha) || !finite(other.force_n))
            fail(fmt::format("the contact of finger {} is on no touchable patch, or not finite", i + 2));
        return other;
    }

    /// The reaction of what a finger feels, by its area coordinates: of a pair, the other's dent is in it.
    std::vector<NodalForce> reaction(const Finger& finger, const ContactFrame& frame) const {
        const Eigen::Vector3d force_n = vector(finger.force_n);
        const Eigen::Vector3d felt_n = frame.pose ? frame.pose->linear().transpose() * force_n : force_n;
        std::vector<NodalForce> loads;
        for (std::size_t i = 0; i < 3; ++i) {
            NodalForce& load = loads.emplace_back();
            load.node = finger.node[i];
            for (std::size_t c = 0; c < 3; ++c)
                load.force_n[c] = static_cast<float>(-finger.alpha[i] * felt_n[static_cast<Eigen::Index>(c)]);
        }
        return loads_.spread(loads);
    }

    void add_others(const Row& row, ContactFrame& out) const {
        for (const Finger& other : row.others) {
            out.others.push_back(
                {vector(other.finger_m), vector(other.god_object_m), vector(other.force_n), other.contact});
            if (!other.contact) continue;
            for (const NodalForce& load : reaction(other, out)) out.loads.push_back(load);
        }
    }

    void add_tool(const Row& row, ContactFrame& out) const {
        const auto pose = pose_of(Eigen::Vector3d::Zero(), {row.tool[0], row.tool[1], row.tool[2]},
                                  {row.tool[3], row.tool[4], row.tool[5], row.tool[6]});
        if (pose) out.tool.emplace(ContactFrame::Tool{*pose, {}});
        for (const Finger& point : row.points) {
            if (out.tool) out.tool->god_object_m.push_back(vector(point.god_object_m));
            for (const NodalForce& load : reaction(point, out)) out.loads.push_back(load);
        }
    }

    void check(const Finger& finger) const {
        if (!finger.contact) {
            if (finger.node != PatchNodes{-1, -1, -1}) fail("names nodes without contact: they must be -1");
            return;
        }
        if (!loads_.is_patch(finger.node))
            fail(
                fmt::format("nodes {}, {}, {} are no touchable patch of {}: give the tables of the servo that wrote "
                            "the file",
                            finger.node[0], finger.node[1], finger.node[2], loads_.tables().name));
        if (!finite(finger.finger_m) || !finite(finger.god_object_m) || !finite(finger.alpha) ||
            !finite(finger.force_n))
            fail("a number of a contact is not finite");
        const auto [least, most] = std::minmax({finger.alpha[0], finger.alpha[1], finger.alpha[2]});
        const double sum = finger.alpha[0] + finger.alpha[1] + finger.alpha[2];
        if (least < -kAlphaSlack || most > 1.0 + kAlphaSlack || std::abs(sum - 1.0) > kAlphaSlack)
            fail(fmt::format("the area coordinates {}, {}, {} must each be in 0..1 and sum to 1", finger.alpha[0],
                             finger.alpha[1], finger.alpha[2]));
    }

    ContactFrame frame(const Row& row) const {
        ContactFrame out;
        out.number = row.tick;
        out.time_s = static_cast<double>(row.tick) * kTick_s;
        out.finger_known = finite(row.first.finger_m);
        out.contact = row.first.contact;
        if (out.finger_known) out.finger_m = vector(row.first.finger_m);
        if (has_pose_)
            out.pose = pose_of({rest_[0], rest_[1], rest_[2]}, {row.pose[0], row.pose[1], row.pose[2]},
                               {row.pose[3], row.pose[4], row.pose[5], row.pose[6]});
        out.modes = row.modes;
        add_others(row, out);
        if (tool_ > 0) add_tool(row, out);
        if (!out.contact) return out;
        out.god_object_m = vector(row.first.god_object_m);
        out.force_n = vector(row.first.force_n);
        if (tool_ > 0) return out;
        const Eigen::Vector3d inside_m = out.pose ? out.pose->inverse() * out.finger_m : out.finger_m;
        const std::vector<NodalForce> loads =
            others_ > 0 || modes_ > 0
                ? reaction(row.first, out)
                : loads_.spread(loads_.of(row.first.node, row.first.alpha, inside_m, out.god_object_m));
        out.loads.insert(out.loads.end(), loads.begin(), loads.end());
        return out;
    }

    std::filesystem::path file_;
    const ContactLoads& loads_;
    int line_ = 0;
    std::size_t columns_ = kColumns;  ///< of this file
    bool has_pose_ = false;
    std::size_t others_ = 0;  ///< fingers beside the first
    std::size_t modes_ = 0;
    std::size_t tool_ = 0, points_ = 0;  ///< of a tool: the column of its place, 0 without one; its points
    std::array<double, kPose> rest_{};   ///< the first row's
};

}  // namespace

std::vector<ContactFrame> read_servo_csv(const std::filesystem::path& file, const ContactLoads& loads,
                                         const FrameChoice& choice) {
    return Reader(file, loads).read(choice);
}

}  // namespace haptable
