// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/scene/device_models.hpp"

namespace haptable {

namespace {

constexpr const char* kAssumed = "assumed";
constexpr const char* kPremium = "Premium";
constexpr const char* kTouch = "Touch";
constexpr const char* kOmega = "omega";
constexpr const char* kFalcon = "Falcon";
constexpr const char* kInverse3 = "Inverse3";
constexpr const char* kNone = "none";

// A driver that exchanges once a tick: the force of one tick acts from the next.
constexpr Figure kOneTick{1e-3, kAssumed};
// Bandwidth of a current amplifier's order.
constexpr Figure kCurrentLoop{1000.0, kAssumed};
constexpr Figure kBearings{0.005, kAssumed};
constexpr std::array<double, 3> kYUp{0.0, 1.0, 0.0}, kZUp{0.0, 0.0, 1.0}, kEndless{0.0, 0.0, 0.0};

}  // namespace

const std::vector<DeviceModel>& device_models() {
    static const std::vector<DeviceModel> all{
        {.name = "phantom",
         .title = "a point with the PHANToM Premium's figures",
         .max_force_n = {8.5, kPremium},
         .continuous_force_n = {1.4, kPremium},
         .mass_kg = {0.075, kPremium},
         .friction_n = {0.04, kPremium},
         .damping_n_s_per_m = kBearings,
         .encoder_step_m = {3.0e-5, kPremium},
         .bandwidth_hz = {0.0, kNone},
         .delay_s = {0.0, kNone},
         .unbalanced = {0.0, kNone},
         .reach_m = kEndless,
         .reach_source = kNone,
         .up = kZUp},
        {.name = "premium-1.0",
         .title = "SensAble PHANToM Premium 1.0",
         .max_force_n = {8.5, kPremium},
         .continuous_force_n = {1.4, kPremium},
         .mass_kg = {0.075, kPremium},
         .friction_n = {0.04, kPremium},
         .damping_n_s_per_m = kBearings,
         .encoder_step_m = {3.0e-5, kPremium},
         .bandwidth_hz = kCurrentLoop,
         .delay_s = kOneTick,
         .unbalanced = {0.0, kPremium},
         .reach_m = {0.254, 0.178, 0.127},
         .reach_source = kPremium,
         .up = kYUp},
        {.name = "touch",
         .title = "3D Systems Touch (SensAble PHANToM Omni)",
         .max_force_n = {3.3, kTouch},
         .continuous_force_n = {0.88, kTouch},
         .mass_kg = {0.045, kTouch},
         .friction_n = {0.26, kTouch},
         .damping_n_s_per_m = kBearings,
         .encoder_step_m = {5.5e-5, kTouch},
         .bandwidth_hz = kCurrentLoop,
         .delay_s = kOneTick,
         .unbalanced = {1.0, kAssumed},
         .reach_m = {0.160, 0.120, 0.070},
         .reach_source = kTouch,
         .up = kYUp},
        {.name = "omega.3",
         .title = "Force Dimension omega.3",
         .max_force_n = {12.0, kOmega},
         .continuous_force_n = {12.0, kOmega},
         .mass_kg = {0.2, kAssumed},
         .friction_n = {0.2, kAssumed},
         .damping_n_s_per_m = kBearings,
         .encoder_step_m = {1.0e-5, kOmega},
         .bandwidth_hz = kCurrentLoop,
         .delay_s = kOneTick,
         .unbalanced = {0.0, kOmega},
         .reach_m = {0.110, 0.160, 0.160},
         .reach_source = kOmega,
         .up = kZUp},
        {.name = "falcon",
         .title = "Novint Falcon",
         .max_force_n = {8.9, kFalcon},
         .continuous_force_n = {8.9, kAssumed},
         .mass_kg = {0.15, kAssumed},
         .friction_n = {0.3, kAssumed},
         .damping_n_s_per_m = kBearings,
         .encoder_step_m = {6.35e-5, kFalcon},
         .bandwidth_hz = kCurrentLoop,
         .delay_s = kOneTick,
         .unbalanced = {1.0, kAssumed},
         .reach_m = {0.1016, 0.1016, 0.1016},
         .reach_source = kFalcon,
         .up = kYUp},
        {.name = "inverse3",
         .title = "Haply Inverse3",
         .max_force_n = {10.0, kInverse3},
         .continuous_force_n = {3.0, kInverse3},
         .mass_kg = {0.2, kAssumed},
         .friction_n = {0.1, kAssumed},
         .damping_n_s_per_m = kBearings,
         .encoder_step_m = {1.0e-5, kAssumed},
         .bandwidth_hz = kCurrentLoop,
         .delay_s = kOneTick,
         .unbalanced = {0.0, kAssumed},
         .reach_m = {0.200, 0.200, 0.200},
         .reach_source = kAssumed,
         .up = kZUp},
        {.name = "ideal",
         .title = "a mass and nothing else",
         .max_force_n = {100.0, kNone},
         .continuous_force_n = {100.0, kNone},
         .mass_kg = {0.05, kNone},
         .friction_n = {0.0, kNone},
         .damping_n_s_per_m = {0.0, kNone},
         .encoder_step_m = {0.0, kNone},
         .bandwidth_hz = {0.0, kNone},
         .delay_s = {0.0, kNone},
         .unbalanced = {0.0, kNone},
         .reach_m = kEndless,
         .reach_source = kNone,
         .up = kZUp},
    };
    return all;
}

const DeviceModel* find_device_model(const std::string& name) {
    for (const DeviceModel& model : device_models())
        if (model.name == name) return &model;
    return nullptr;
}

Device device_of(const DeviceModel& model) {
    Device device;
    device.model = model.name;
    device.max_force_n = model.max_force_n.value;
    device.continuous_force_n = model.continuous_force_n.value;
    device.mass_kg.fill(model.mass_kg.value);
    device.damping_n_s_per_m = model.damping_n_s_per_m.value;
    device.friction_n = model.friction_n.value;
    device.encoder_step_m = model.encoder_step_m.value;
    device.bandwidth_hz = model.bandwidth_hz.value;
    device.delay_s = model.delay_s.value;
    device.unbalanced = model.unbalanced.value;
    device.up = model.up;
    device.reach_m = model.reach_m;
    return device;
}

}  // namespace haptable
