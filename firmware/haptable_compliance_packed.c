/* SPDX-License-Identifier: MIT
 *
 * C(alpha) and E(alpha) with blocks in 16 bits, expanded on the stack.
 */
#include "haptable_net.h"

/* The blocks of a patch, expanded into `room`. Those of vertices, edges and patches stand in a row, an edge's from its
 * lower vertex to its higher one. */
static inline void gather_packed(const struct haptable_model* model, const struct haptable_compliance_form* form,
                                 uint16_t patch, float (*room)[6], struct net* net) {
    const struct haptable_compliance* c = model->compliance;
    const uint16_t* v = model->patch[patch];
    const uint32_t per_edge = form->degree - 1u;
    const uint32_t edges = model->vertex_count;
    const uint32_t patches = edges + per_edge * c->edge_count;
    int corner;
    int n;
    net->count = form->degree == 4 ? HAPTABLE_COMPLIANCE_CONTROLS : 6;
    for (corner = 0; corner < 3; ++corner) {
        const int forward = v[next_corner(corner)] < v[previous_corner(corner)];
        const uint32_t first = edges + per_edge * c->patch_edge[patch][corner];
        uint32_t i;
        model->unpack(model, v[corner], room[form->vertex[corner]]);
        for (i = 0; i < per_edge; ++i)
            model->unpack(model, first + (forward ? i : per_edge - 1u - i), room[form->edge[corner][i]]);
        if (form->degree == 4)
            model->unpack(model, patches + 3u * (uint32_t)patch + (uint32_t)corner, room[form->inside[corner]]);
    }
    for (n = 0; n < net->count; ++n) net->block[n] = room[n];
}

void haptable_compliance_load_packed(const struct haptable_model* model, const struct haptable_compliance_form* form,
                                     const struct haptable_contact* contact, const float finger_m[3], float load_n[3]) {
    float room[HAPTABLE_COMPLIANCE_CONTROLS][6];
    struct net net;
    gather_packed(model, form, contact->patch, room, &net);
    load_of(model, &net, form->degree, contact, finger_m, load_n);
}

void haptable_compliance_energy_packed(const struct haptable_model* model, const struct haptable_compliance_form* form,
                                       const struct haptable_contact* contact, const float finger_m[3],
                                       enum haptable_energy_terms terms, struct haptable_energy* energy) {
    float room[HAPTABLE_COMPLIANCE_CONTROLS][6];
    struct net net;
    gather_packed(model, form, contact->patch, room, &net);
    energy_of(model, &net, form->degree, contact, finger_m, terms, energy);
}
