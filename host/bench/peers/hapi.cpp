// SPDX-License-Identifier: GPL-2.0-or-later
// HAPI's god-object renderer on a tree of axis-aligned boxes, as a peer of haptable-contact. No code of HAPI is here:
// scripts/peers.sh brings its source and compiles this file with it.
#include <HAPI/FrictionSurface.h>
#include <HAPI/GodObjectRenderer.h>
#include <HAPI/HAPIHapticsDevice.h>
#include <HAPI/HapticTriangleTree.h>

#include <memory>

#include "host/bench/peers/peer.h"

namespace {

/// A device that is where it is told to be.
struct Placed : HAPI::HAPIHapticsDevice {
    Placed() { haptics_rate = 1000; }
    bool initHapticsDevice(int /*rate*/) override { return true; }
    bool releaseHapticsDevice() override { return true; }
    void sendOutput(DeviceOutput& /*output*/, HAPI::HAPITime /*dt*/) override {}
    void put(const double x[3]) { current_device_values.position = HAPI::Vec3(x[0], x[1], x[2]); }
};

struct Peer {
    Placed device;
    HAPI::HAPIHapticsRenderer::HapticShapeVector shapes;
    std::unique_ptr<HAPI::GodObjectRenderer> renderer;
};

}  // namespace

void* haptable_peer_make(const double* point_m, const int* patch, int patches, double stiffness_n_per_m,
                         double static_friction, double dynamic_friction) {
    std::vector<HAPI::Collision::Triangle> triangles;
    const auto corner = [&](int i) {
        const double* x = point_m + 3 * patch[i];
        return HAPI::Vec3(x[0], x[1], x[2]);
    };
    for (int i = 0; i < 3 * patches; i += 3)
        triangles.push_back(HAPI::Collision::Triangle(corner(i), corner(i + 1), corner(i + 2)));
    Peer* peer = new Peer;
    peer->shapes.push_back(new HAPI::HapticTriangleTree(
        new HAPI::Collision::AABBTree(triangles),
        new HAPI::FrictionSurface(stiffness_n_per_m, 0.0, static_friction, dynamic_friction, false),
        HAPI::Collision::FRONT));
    return peer;
}

void haptable_peer_begin(void* peer, const double finger_m[3]) {
    Peer& it = *static_cast<Peer*>(peer);
    it.renderer.reset(new HAPI::GodObjectRenderer);  // it moves towards a finger that jumps by a twentieth a tick
    double force_n[3];
    haptable_peer_step(peer, finger_m, force_n);
}

void haptable_peer_step(void* peer, const double finger_m[3], double force_n[3]) {
    Peer& it = *static_cast<Peer*>(peer);
    it.device.put(finger_m);
    const HAPI::Vec3 force = it.renderer->renderHapticsOneStep(&it.device, it.shapes, 0.001).force;
    force_n[0] = force.x;
    force_n[1] = force.y;
    force_n[2] = force.z;
}
