// SPDX-License-Identifier: GPL-2.0-or-later
// CHAI3D's finger proxy on a tree of axis-aligned boxes, as a peer of haptable-contact. No code of CHAI3D is here:
// scripts/peers.sh brings its source and compiles this file with it.
#include <collisions/CCollisionAABB.h>
#include <forces/CAlgorithmFingerProxy.h>
#include <world/CMesh.h>
#include <world/CWorld.h>

#include <memory>

#include "host/bench/peers/peer.h"

namespace {

struct Peer {
    chai3d::cWorld world;
    std::unique_ptr<chai3d::cAlgorithmFingerProxy> proxy;
};

chai3d::cVector3d vector_of(const double x[3]) { return {x[0], x[1], x[2]}; }

}  // namespace

void* haptable_peer_make(const double* point_m, const int* patch, int patches, double stiffness_n_per_m,
                         double static_friction, double dynamic_friction) {
    auto* mesh = new chai3d::cMesh;
    const auto corner = [&](int i) { return vector_of(point_m + 3 * patch[i]); };
    for (int i = 0; i < 3 * patches; i += 3) mesh->newTriangle(corner(i), corner(i + 1), corner(i + 2));
    mesh->m_material->setStiffness(stiffness_n_per_m);
    mesh->m_material->setHapticTriangleSides(true, false);
    mesh->m_material->setStaticFriction(static_friction);
    mesh->m_material->setDynamicFriction(dynamic_friction);
    mesh->m_material->setUseHapticFriction(static_friction > 0.0 || dynamic_friction > 0.0);
    mesh->createAABBCollisionDetector(0.0);
    Peer* peer = new Peer;
    peer->world.addChild(mesh);
    peer->world.computeGlobalPositions();
    return peer;
}

void haptable_peer_begin(void* peer, const double finger_m[3]) {
    Peer& it = *static_cast<Peer*>(peer);
    it.proxy.reset(new chai3d::cAlgorithmFingerProxy);
    it.proxy->setProxyRadius(0.0);
    it.proxy->initialize(&it.world, vector_of(finger_m));
}

void haptable_peer_step(void* peer, const double finger_m[3], double force_n[3]) {
    const chai3d::cVector3d force =
        static_cast<Peer*>(peer)->proxy->computeForces(vector_of(finger_m), chai3d::cVector3d());
    for (int c = 0; c < 3; ++c) force_n[c] = force(c);
}
