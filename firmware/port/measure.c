/* SPDX-License-Identifier: MIT
 *
 * Like replay.c, with a model that it reads instead of one that it is linked with: every mode of the servo on every
 * body from one image, for tests and counts. Its words: measure IN OUT. IN holds the model as
 * host/target/model_file.cpp writes it, then the path. The tables lie in RAM: for boards like QEMU's, with megabytes of
 * it.
 */
#include "haptable.h"
#include "haptable_port.h"
#include "haptable_semihosting.h"
#include "haptable_ticks.h"

/* The file's first words. */
struct model_head {
    uint32_t god_object; /* 0 nearest, 1 least-energy */
    uint32_t has_friction;
    uint32_t force;  /* 0 interpolated, 1 consistent, 2 pressure-mask, 3 of least-energy */
    uint32_t energy; /* 0 none, 1 interpolated, 2 consistent, 3 pressure-mask */
    uint32_t unpack; /* 0: float32, 1: float16, 2: int16 */
    uint32_t has_release;
    uint32_t has_passivity;
    uint32_t degree; /* of the compliance; 0: none */
    uint32_t vertex_count;
    uint32_t free_count;
    uint32_t patch_count;
    uint32_t box_count;
    uint32_t hinge_count;
    uint32_t edge_count;
    float max_force_n;
    float rigid_stiffness_n_per_m;
    float tolerance_m;
    float workspace_limit_m;
    float grid_origin_m[3];
    float grid_per_m;
    float static_friction;
    float kinetic_friction;
    float stiffness_limit_n_per_m;
    float release_n;
};

/* Where the tables go: mask tables of a body of 2,400 patches take half a megabyte. */
static uint32_t arena[256u * 1024u];
static uint32_t used;
static struct haptable_compliance compliance;
static struct haptable_model model;

/* The next table of the file; 0 when there is no room. Every table is padded to whole words. */
static void* take(int in, uint32_t bytes) {
    const uint32_t words = (bytes + 3u) / 4u;
    uint32_t* table = &arena[used];
    if (words > sizeof arena / sizeof arena[0] - used) return 0;
    if (words > 0 && haptable_semihosting_read(in, table, 4u * words) != 4u * words) return 0;
    used += words;
    return table;
}

static int take_shape(int in, const struct model_head* head) {
    model.vertex_m = take(in, 12u * head->vertex_count);
    model.patch = take(in, 6u * head->patch_count);
    model.neighbour = take(in, 6u * head->patch_count);
    model.box = take(in, 16u * head->box_count);
    model.hinge = take(in, 6u * head->hinge_count);
    return model.vertex_m && model.patch && model.neighbour && model.box && model.hinge;
}

static int take_stiffness(int in, const struct model_head* head) {
    static haptable_unpack_fn* const unpack[] = {0, haptable_unpack_float16, haptable_unpack_int16};
    if (head->unpack == 0) {
        model.stiffness_n_per_m = take(in, 24u * head->free_count);
        return model.stiffness_n_per_m != 0;
    }
    model.unpack = unpack[head->unpack];
    model.packed = take(in, 12u * head->free_count);
    model.packed_scale_n_per_m = take(in, 4u * (head->unpack == 1 ? 1u : head->free_count));
    return model.packed && model.packed_scale_n_per_m;
}

static int take_compliance(int in, const struct model_head* head) {
    compliance.degree = (uint8_t)head->degree;
    compliance.edge_count = (uint16_t)head->edge_count;
    compliance.vertex = take(in, 24u * head->vertex_count);
    compliance.edge = take(in, 24u * head->edge_count * (head->degree - 1u));
    compliance.patch = take(in, head->degree == 4 ? 72u * head->patch_count : 0u);
    compliance.patch_edge = take(in, 6u * head->patch_count);
    model.compliance = &compliance;
    return compliance.vertex && compliance.edge && compliance.patch && compliance.patch_edge;
}

static void name_functions(const struct model_head* head) {
    static haptable_god_object_fn* const god_object[] = {haptable_god_object_nearest, haptable_god_object_least_energy};
    static haptable_force_fn* const force[] = {haptable_force_interpolated, haptable_force_consistent,
                                               haptable_force_pressure_mask, haptable_force_of_least_energy};
    static haptable_energy_fn* const energy[] = {0, haptable_energy_interpolated, haptable_energy_consistent,
                                                 haptable_energy_pressure_mask};
    model.god_object = god_object[head->god_object];
    if (head->has_friction) {
        model.frictionless = model.god_object;
        model.god_object = haptable_god_object_friction;
    }
    model.force = force[head->force];
    model.energy = energy[head->energy];
    if (head->has_release) model.release = haptable_release_slew;
    if (head->has_passivity) model.passivity = haptable_passivity_control;
}

static void take_numbers(const struct model_head* head) {
    int axis;
    model.max_force_n = head->max_force_n;
    model.rigid_stiffness_n_per_m = head->rigid_stiffness_n_per_m;
    model.tolerance_m = head->tolerance_m;
    model.workspace_limit_m = head->workspace_limit_m;
    for (axis = 0; axis < 3; ++axis) model.grid_origin_m[axis] = head->grid_origin_m[axis];
    model.grid_per_m = head->grid_per_m;
    model.vertex_count = (uint16_t)head->vertex_count;
    model.free_count = (uint16_t)head->free_count;
    model.patch_count = (uint16_t)head->patch_count;
    model.box_count = (uint16_t)head->box_count;
    model.hinge_count = (uint16_t)head->hinge_count;
    model.static_friction = head->static_friction;
    model.kinetic_friction = head->kinetic_friction;
    model.stiffness_limit_n_per_m = head->stiffness_limit_n_per_m;
    model.release_n = head->release_n;
}

static int take_model(int in) {
    struct model_head head;
    if (haptable_semihosting_read(in, &head, sizeof head) != sizeof head) return 0;
    if (head.god_object > 1 || head.force > 3 || head.energy > 3 || head.unpack > 2) return 0;
    name_functions(&head);
    take_numbers(&head);
    if (!take_shape(in, &head)) return 0;
    return head.degree == 0 ? take_stiffness(in, &head) : take_compliance(in, &head);
}

int haptable_port_main(void) {
    int in;
    int out;
    const int status = haptable_semihosting_files(&in, &out);
    if (status != 0) return status;
    if (!take_model(in)) return 65;
    haptable_ticks_replay(&model, in, out);
    return 0;
}
