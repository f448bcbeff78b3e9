// SPDX-License-Identifier: GPL-2.0-or-later
// The Novint Falcon over its serial line, with Novint's firmware in it already (libnifalcon's findfalcons loads it; its
// licence lets nobody else ship it). The grip's place is told from the middle of its travel.
#include <array>
#include <cmath>

#include "host/base/command_line.hpp"
#include "host/device/drivers.hpp"
#include "host/device/exchange_driver.hpp"
#include "host/device/falcon.hpp"
#include "host/link/line.hpp"

namespace haptable {

namespace {

constexpr unsigned kFalconBaud = 1'456'312;
constexpr std::uint8_t kAllHomed = 7;

// libnifalcon's: a motor's value for a torque of its leg, N m; what a value's worth is nobody has measured here.
constexpr double kValuePerNm = -10'000.0, kMostValue = 4095.0;

const Eigen::Vector3d kMiddle_m{0.0, 0.0, 0.11};

class FalconDriver : public ExchangeDriver {
public:
    explicit FalconDriver(const DriverOptions& options)
        : ExchangeDriver(options.port, options), line_(Line::open(options.port, kFalconBaud, Speeds::any)) {
        wait_for_first(
            options.patience_s,
            "is Novint's firmware loaded (findfalcons)? While its light is red, push the grip in and pull it "
            "out once");
    }
    ~FalconDriver() override { send_no_force(); }

private:
    void send(const Eigen::Vector3d& force_n) override {
        std::array<std::int16_t, 3> motor{};
        if (const auto jacobian = homed_ ? falcon_jacobian(angle_, grip_m_) : std::nullopt) {
            Eigen::Vector3d value = kValuePerNm * jacobian->transpose() * force_n;
            // All by one factor: the force keeps its direction.
            if (const double most = value.cwiseAbs().maxCoeff(); most > kMostValue) value *= kMostValue / most;
            for (std::size_t leg = 0; leg < 3; ++leg)
                motor[leg] = static_cast<std::int16_t>(std::lround(value[static_cast<Eigen::Index>(leg)]));
        }
        line_.write(falcon_frame(motor, !homed_));
    }

    bool take(Reading& reading) override {
        std::array<std::uint8_t, 256> bytes;
        bool is_new = false;
        std::int64_t odd = 0;
        for (std::size_t got = 0; (got = line_.read(bytes)) > 0;)
            if (const auto state = reader_.add({bytes.data(), got}, odd)) is_new = use(*state, reading);
        if (odd > 0) count_odd();
        return is_new;
    }

    /// Encoders count from where the motors were switched on, until the legs have been home.
    bool use(const FalconState& state, Reading& reading) {
        homed_ = state.homed == kAllHomed;
        if (!homed_) return false;
        Eigen::Vector3d angle;
        for (std::size_t leg = 0; leg < 3; ++leg)
            angle[static_cast<Eigen::Index>(leg)] = falcon_angle(state.encoder[leg]);
        const auto grip_m = falcon_grip_m(angle, grip_m_);
        if (!grip_m || !(grip_m->z() > 0.0)) {
            count_odd();
            return false;
        }
        angle_ = angle;
        grip_m_ = *grip_m;
        reading.position_m = grip_m_ - kMiddle_m;
        reading.buttons = state.buttons & (kClutchButton | kGrabButton | kAcknowledgeButton);
        return true;
    }

    Line line_;
    FalconReader reader_;
    bool homed_ = false;
    Eigen::Vector3d angle_ = Eigen::Vector3d::Zero(), grip_m_ = kMiddle_m;
};

}  // namespace

std::unique_ptr<Driver> open_falcon(const DriverOptions& options) {
    if (options.port.empty()) throw BadCommandLine("--driver falcon: needs --port, such as /dev/ttyUSB0");
    return std::make_unique<FalconDriver>(options);
}

}  // namespace haptable
