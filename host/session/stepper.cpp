// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/session/stepper.hpp"

#include <algorithm>

namespace haptable {

haptable_output silent_output() {
    haptable_output output{};
    output.patch = HAPTABLE_NONE;
    std::fill_n(output.vertex, 3, HAPTABLE_NONE);
    return output;
}

Stepper::Stepper(const ServoScene& scene) : scene_(scene) {
    std::fill_n(out_.begin(), finger_count(), silent_output());
}

Clock::time_point Stepper::free_at(bool /*is_lockstep*/) const { return Clock::time_point::min(); }

bool Stepper::is_first_tick(const FingerInputs& in) const {
    for (std::size_t finger = 0; finger < finger_count(); ++finger)
        if (in[finger] && !in[finger]->begins && out_[finger].state != HAPTABLE_SILENT) return false;
    return true;
}

void Stepper::note(const FingerInputs& in) {
    double given_j = 0.0;
    for (std::size_t finger = 0; finger < finger_count(); ++finger) {
        if (in[finger]) {
            const std::array<float, 3>& at_m = in[finger]->at_m;
            std::array<float, 3> inside_m = at_m;
            if (scene_.body != nullptr) haptable_body_from_world(scene_.body, touched(), at_m.data(), inside_m.data());
            const ToolOutput* const held = tool();
            const ToolWork work =
                held != nullptr ? ToolWork{in[finger]->turn, held->torque_n_m, held->stored_j} : ToolWork();
            forces_[finger].note(at_m, out_[finger], inside_m, held != nullptr ? &work : nullptr);
        }
        given_j += forces_[finger].energy.given_j();
    }
    most_given_j_ = std::max(most_given_j_, given_j);
}

}  // namespace haptable
