// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/session/tell.hpp"

#include <fmt/format.h>

#include <cmath>

namespace haptable {

void tell_of_states(const StateCounters& counters, Clock::time_point now, LiveState& live, const std::string& who) {
    const auto look = [&](const char* counter, std::int64_t value, const char* text) {
        live.look(who + counter, value, now, [&] { return who + text; });
    };
    look("foreign_states", counters.foreign_states,
         "a device of another scene (or of older tables) is on the channel: it is not answered; start it with this "
         "servo's scene");
    look("other_servo_states", counters.other_servo_states,
         "a second servo is on the channel, and a device belongs to it: that device is not answered here");
    look("other_device_states", counters.other_device_states,
         who.empty() ? "a second device is on the channel: it gets no force until the first has been silent for 20 ms"
                     : "a second device speaks for it, which gets no force until the first has been silent for 20 ms: "
                       "is it to be --finger 2?");
    look("late_states", counters.late_states,
         "states come 20 ms late or more, and are left out: is the machine too busy, or the device's clock off?");
    look("absent_finger_states", counters.absent_finger_states,
         "a device speaks for a second finger, and the scene has one: write fingers = 2 in [contact], or leave out its "
         "--finger 2");
}

std::string why_rejected(const haptable_model& model, const std::array<float, 3>& position_m) {
    double far2 = 0.0, as_mm2 = 0.0;
    for (std::size_t a = 0; a < 3; ++a) {
        const double x = double{position_m[a]}, origin = double{model.grid_origin_m[a]};
        far2 += (x - origin) * (x - origin);
        as_mm2 += (1e-3 * x - origin) * (1e-3 * x - origin);
    }
    const std::string what = fmt::format("position {:.6g} {:.6g} {:.6g} m rejected, no force: ", position_m[0],
                                         position_m[1], position_m[2]);
    const double limit_m = double{model.workspace_limit_m};
    if (!std::isfinite(far2)) return what + "it is not a number";
    if (std::sqrt(far2) <= limit_m) return what + "it is not believed until 20 good ones have come";
    if (std::sqrt(as_mm2) <= limit_m) return what + "it looks like millimetres, and must be in metres";
    return what + fmt::format("it is {:.3g} m from the body", std::sqrt(far2));
}

std::string contact_dropped_after(Clock::duration silence) {
    return fmt::format("contact dropped after a silence of {:.0f} ms: the device sends nothing", 1e-3 * to_us(silence));
}

}  // namespace haptable
