// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/servo_csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <set>
#include <string_view>

#include "host/base/error.hpp"
#include "host/base/file.hpp"

namespace haptable {

namespace {

constexpr std::string_view kHeader =
    "tick,x,y,z,contact,node_i,node_j,node_k,alpha_i,alpha_j,alpha_k,god_x,god_y,god_z,force_x,force_y,force_z";
constexpr std::size_t kColumns = 17;  // a file may have more behind them
// Columns of a body that nothing holds, in the last columns.
constexpr std::string_view kPoseColumns = ",body_x,body_y,body_z,turn_w,turn_x,turn_y,turn_z";
constexpr std::size_t kPose = 7;
// Columns of a second finger, behind the first's and its buttons, state and faults.
constexpr std::string_view kSecondColumns = ",faults,x2,y2,z2,contact2,";
constexpr std::size_t kSecond = 20, kSecondEnd = 36;
constexpr double kTick_s = 0.001;
// The servo computes area coordinates in single precision: they may miss 0, 1 and the sum 1 by some of its last digits.
constexpr double kAlphaSlack = 1e-4;

struct Row {
    std::int64_t tick = 0;
    int contact = 0;
    PatchNodes node{};
    std::array<double, 3> finger_m{}, alpha{}, god_object_m{}, force_n{};
    std::array<double, kPose> pose{};
    /// The second finger's; without contact its position alone.
    struct Second {
        bool contact = false;
        PatchNodes node{};
        std::array<double, 3> finger_m{}, alpha{}, god_object_m{}, force_n{};
    };
    std::optional<Second> second;
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
        if (!header.starts_with(kHeader) || !(more.empty() || more.front() == ','))
            fail(
                "the header is not the one of a servo's CSV: it begins with tick,x,y,z,contact; give the file that "
                "servo --replay IN --out OUT wrote");
        has_pose_ = header.ends_with(kPoseColumns);
        for (std::size_t at = 0; (at = header.find(",mode_", at)) != std::string_view::npos; ++at) ++modes_;
        has_second_ = header.find(kSecondColumns) != std::string_view::npos;
        std::vector<ContactFrame> frames;
        std::size_t rows = 0;
        std::set<std::int64_t> wanted(choice.ticks.begin(), choice.ticks.end());
        std::int64_t last = -1;
        while (!rest.empty()) {
            const Row row = parse(next_line(rest));
            if (row.tick <= last) fail(fmt::format("tick {} comes after tick {}: ticks must rise", row.tick, last));
            check(row);
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
        const auto [stop, error] = std::from_chars(field.data(), field.data() + field.size(), value);
        if (error != std::errc() || stop != field.data() + field.size())
            fail(fmt::format("{} is \"{}\", which is no number: make the file again with the servo", column,
                             field.substr(0, 40)));
        return value;
    }

    Row parse(std::string_view line) const {
        std::array<std::string_view, kColumns> field;
        const auto commas = static_cast<std::size_t>(std::count(line.begin(), line.end(), ','));
        if (commas + 1 != columns_)
            fail(fmt::format("has {} columns where {} belong: is the file cut off?", line.empty() ? 0 : commas + 1,
                             columns_));
        const std::string_view whole = line;
        for (std::string_view& f : field) {
            const std::size_t comma = line.find(',');
            f = line.substr(0, comma);
            line.remove_prefix(comma == std::string_view::npos ? line.size() : comma + 1);
        }
        Row row;
        row.tick = number<std::int64_t>(field[0], "tick");
        row.contact = number<int>(field[4], "contact");
        for (std::size_t i = 0; i < 3; ++i) {
            row.finger_m[i] = number<double>(field[1 + i], "the finger's position");
            row.node[i] = number<std::int32_t>(field[5 + i], "a node");
            row.alpha[i] = number<double>(field[8 + i], "an area coordinate");
            row.god_object_m[i] = number<double>(field[11 + i], "the god-object's position");
            row.force_n[i] = number<double>(field[14 + i], "the force");
        }
        if (has_pose_) row.pose = pose(whole);
        if (modes_ > 0) row.modes = modes(whole);
        if (has_second_) row.second = second(whole);
        return row;
    }

    std::optional<Row::Second> second(std::string_view line) const {
        std::vector<std::string_view> field;
        for (std::size_t k = 0; k < kSecondEnd; ++k) {
            const std::size_t comma = line.find(',');
            field.push_back(line.substr(0, comma));
            line.remove_prefix(comma == std::string_view::npos ? line.size() : comma + 1);
        }
        Row::Second second;
        for (std::size_t i = 0; i < 3; ++i)
            second.finger_m[i] = number<double>(field[kSecond + i], "the second finger's position");
        second.contact = number<int>(field[kSecond + 3], "contact2") == 1;
        if (!second.contact) return finite(second.finger_m) ? std::optional(second) : std::nullopt;
        for (std::size_t i = 0; i < 3; ++i) {
            second.node[i] = number<std::int32_t>(field[kSecond + 4 + i], "a node");
            second.alpha[i] = number<double>(field[kSecond + 7 + i], "an area coordinate");
            second.god_object_m[i] = number<double>(field[kSecond + 10 + i], "the second god-object's position");
            second.force_n[i] = number<double>(field[kSecond + 13 + i], "the second force");
        }
        if (!loads_.is_patch(second.node) || !finite(second.finger_m) || !finite(second.god_object_m) ||
            !finite(second.alpha) || !finite(second.force_n))
            fail("the second finger's contact is on no touchable patch, or not finite");
        return second;
    }

    /// The reaction of what a finger feels, by its area coordinates: of a pair, the other's dent is in it.
    std::vector<NodalForce> reaction(const PatchNodes& node, const std::array<double, 3>& alpha,
                                     const std::array<double, 3>& force_n, const ContactFrame& frame) const {
        const Eigen::Vector3d felt_n =
            frame.pose ? frame.pose->linear().transpose() * vector(force_n) : vector(force_n);
        std::vector<NodalForce> loads;
        for (std::size_t i = 0; i < 3; ++i) {
            NodalForce& load = loads.emplace_back();
            load.node = node[i];
            for (std::size_t c = 0; c < 3; ++c)
                load.force_n[c] = static_cast<float>(-alpha[i] * felt_n[static_cast<Eigen::Index>(c)]);
        }
        return loads_.spread(loads);
    }

    void add_second(const Row& row, ContactFrame& out) const {
        const Row::Second& second = *row.second;
        out.second = {vector(second.finger_m), vector(second.god_object_m), vector(second.force_n), second.contact};
        if (!second.contact) return;
        for (const NodalForce& load : reaction(second.node, second.alpha, second.force_n, out))
            out.loads.push_back(load);
    }

    /// The last columns.
    std::array<double, kPose> pose(std::string_view line) const {
        std::array<double, kPose> numbers{};
        for (std::size_t k = kPose; k-- > 0;) {
            const std::size_t comma = line.rfind(',');
            numbers[k] = number<double>(line.substr(comma + 1), "the body's place");
            line = line.substr(0, comma);
        }
        return numbers;
    }

    /// The columns before those of the pose, or the last.
    std::vector<float> modes(std::string_view line) const {
        std::vector<float> swung(modes_);
        for (std::size_t k = modes_ + (has_pose_ ? kPose : 0); k-- > 0;) {
            const std::size_t comma = line.rfind(',');
            if (k < modes_) swung[k] = number<float>(line.substr(comma + 1), "a mode");
            line = line.substr(0, comma);
        }
        return swung;
    }

    void check(const Row& row) const {
        if (row.contact != 0 && row.contact != 1) fail(fmt::format("contact is {}: it must be 0 or 1", row.contact));
        if (row.contact == 0) {
            if (row.node != PatchNodes{-1, -1, -1}) fail("names nodes without contact: they must be -1");
            return;
        }
        if (!loads_.is_patch(row.node))
            fail(
                fmt::format("nodes {}, {}, {} are no touchable patch of {}: give the tables of the servo that wrote "
                            "the file",
                            row.node[0], row.node[1], row.node[2], loads_.tables().name));
        if (!finite(row.finger_m) || !finite(row.god_object_m) || !finite(row.alpha) || !finite(row.force_n))
            fail("a number of a contact is not finite");
        const auto [least, most] = std::minmax({row.alpha[0], row.alpha[1], row.alpha[2]});
        const double sum = row.alpha[0] + row.alpha[1] + row.alpha[2];
        if (least < -kAlphaSlack || most > 1.0 + kAlphaSlack || std::abs(sum - 1.0) > kAlphaSlack)
            fail(fmt::format("the area coordinates {}, {}, {} must each be in 0..1 and sum to 1", row.alpha[0],
                             row.alpha[1], row.alpha[2]));
    }

    ContactFrame frame(const Row& row) const {
        ContactFrame out;
        out.number = row.tick;
        out.time_s = static_cast<double>(row.tick) * kTick_s;
        out.finger_known = finite(row.finger_m);
        out.contact = row.contact == 1;
        if (out.finger_known) out.finger_m = vector(row.finger_m);
        if (has_pose_)
            out.pose = pose_of({rest_[0], rest_[1], rest_[2]}, {row.pose[0], row.pose[1], row.pose[2]},
                               {row.pose[3], row.pose[4], row.pose[5], row.pose[6]});
        out.modes = row.modes;
        if (row.second) add_second(row, out);
        if (!out.contact) return out;
        out.god_object_m = vector(row.god_object_m);
        out.force_n = vector(row.force_n);
        const Eigen::Vector3d inside_m = out.pose ? out.pose->inverse() * out.finger_m : out.finger_m;
        const std::vector<NodalForce> loads =
            has_second_ || modes_ > 0 ? reaction(row.node, row.alpha, row.force_n, out)
                                      : loads_.spread(loads_.of(row.node, row.alpha, inside_m, out.god_object_m));
        out.loads.insert(out.loads.end(), loads.begin(), loads.end());
        return out;
    }

    std::filesystem::path file_;
    const ContactLoads& loads_;
    int line_ = 0;
    std::size_t columns_ = kColumns;  ///< of this file
    bool has_pose_ = false, has_second_ = false;
    std::size_t modes_ = 0;
    std::array<double, kPose> rest_{};  ///< the first row's
};

}  // namespace

std::vector<ContactFrame> read_servo_csv(const std::filesystem::path& file, const ContactLoads& loads,
                                         const FrameChoice& choice) {
    return Reader(file, loads).read(choice);
}

}  // namespace haptable
