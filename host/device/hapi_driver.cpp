// SPDX-License-Identifier: GPL-2.0-or-later
// Haply's 2diy by the hAPI's serial protocol: [1, device, set-up], then [2, device, torques], answered by
// [device, angles]; floats of 32 bits, the low byte first, N m and degrees. There is no checksum.
#include <array>
#include <bit>
#include <numbers>
#include <vector>

#include "host/base/command_line.hpp"
#include "host/device/drivers.hpp"
#include "host/device/exchange_driver.hpp"
#include "host/device/five_bar.hpp"
#include "host/link/line.hpp"

namespace haptable {

namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint8_t kReset = 0, kSetUp = 1, kTorques = 2, kDevice = 5;
constexpr std::size_t kAnswer = 1 + 2 * sizeof(float);
constexpr unsigned kHapiBaud = 57600;  // of no account over USB
constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;

void add(float value, Bytes& bytes) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<std::uint8_t>(bits >> shift));
}

float float_at(const std::uint8_t* bytes) {
    std::uint32_t bits = 0;
    for (int i = 3; i >= 0; --i) bits = bits << 8 | bytes[i];
    return std::bit_cast<float>(bits);
}

/// What the two hardware versions are set up with, as Haply's own examples do: the motors on ports 2 and 1, so that the
/// second stands first in every message; each with its direction, its encoder's offset in degrees and counts a turn.
Bytes set_up(int hardware) {
    const bool plastic = hardware == 3;
    const std::uint8_t second = plastic ? 1 : 0, first = 1, ports_1_and_2 = 3;
    Bytes bytes{kSetUp, kDevice, ports_1_and_2, second, first, ports_1_and_2, second, first, 0, 0};
    for (const float value :
         plastic ? std::array{12.0F, 4880.0F, 168.0F, 4880.0F} : std::array{-61.0F, 10752.0F, 241.0F, 10752.0F})
        add(value, bytes);
    return bytes;
}

class HapiDriver : public ExchangeDriver {
public:
    explicit HapiDriver(const DriverOptions& options)
        : ExchangeDriver(options.port, options), line_(Line::open(options.port, kHapiBaud)) {
        if (options.hardware == 3) linkage_.base_m = 0.038;
        line_.write(Bytes{kReset, 0});
        line_.write(set_up(options.hardware));
        wait_for_first(options.patience_s, "is it a 2diy with the hAPI's firmware, and its supply on?");
    }
    ~HapiDriver() override { send_no_force(); }

private:
    void send(const Eigen::Vector3d& force_n) override {
        Eigen::Vector2d torque_nm = Eigen::Vector2d::Zero();
        // Without a reading, or with the arms in a line, there is no torque that makes this force.
        if (const auto jacobian = has_angle_ ? linkage_.jacobian(angle_) : std::nullopt)
            torque_nm = jacobian->transpose() * force_n.head<2>();
        Bytes bytes{kTorques, kDevice};
        for (const int motor : {1, 0}) add(static_cast<float>(torque_nm[motor]), bytes);
        line_.write(bytes);
    }

    bool take(Reading& reading) override {
        std::array<std::uint8_t, 256> bytes;
        std::size_t got = 0, all = 0;
        for (; (got = line_.read(bytes)) > 0; all += got)
            held_.insert(held_.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(got));
        bool is_new = false;
        std::size_t at = 0;
        for (; held_.size() - at >= kAnswer; at += is_answer(held_.data() + at, reading, is_new) ? kAnswer : 1) {
        }
        held_.erase(held_.begin(), held_.begin() + static_cast<std::ptrdiff_t>(at));
        if (all == 0 && !held_.empty()) {
            // What a tick has not completed is no answer: the board sends one at a time.
            count_odd();
            held_.clear();
        }
        return is_new;
    }

    bool is_answer(const std::uint8_t* bytes, Reading& reading, bool& is_new) {
        const Eigen::Vector2d degrees(static_cast<double>(float_at(bytes + 5)),
                                      static_cast<double>(float_at(bytes + 1)));
        const Eigen::Vector2d angle = kRadiansPerDegree * degrees;
        const bool is_turn = degrees.allFinite() && degrees.cwiseAbs().maxCoeff() <= 360.0;
        const auto end = bytes[0] == kDevice && is_turn ? linkage_.end_m(angle) : std::nullopt;
        if (!end) {
            count_odd();
            return false;
        }
        angle_ = angle;
        has_angle_ = is_new = true;
        reading.position_m = {end->x(), end->y(), 0.0};
        return true;
    }

    Line line_;
    FiveBar linkage_;
    Eigen::Vector2d angle_ = Eigen::Vector2d::Zero();  ///< rad, of the first and the second motor
    bool has_angle_ = false;
    Bytes held_;
};

}  // namespace

std::unique_ptr<Driver> open_hapi(const DriverOptions& options) {
    if (options.port.empty()) throw BadCommandLine("--driver hapi: needs --port, such as /dev/ttyACM0");
    if (options.hardware != 2 && options.hardware != 3)
        throw BadCommandLine("--hardware: is 3 for the plastic 2diy, or 2 for the metal one");
    return std::make_unique<HapiDriver>(options);
}

}  // namespace haptable
