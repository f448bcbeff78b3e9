/* SPDX-License-Identifier: MIT
 *
 *   p += F dt, L += r x F dt;   then 2/dt M (V_m - V) = F_w + N(V_m) - C V_m,   p+ = p + dt v_m,   q+ = q + dt/2 q_m
 * (0, w_m) (2/dt M + C) (V_m - V) = F_w + N(V_m) - C V is what is solved; V_m is the mean of V before and after
 *
 * Fingers kick, then the body drifts: action is reaction at every tick, and hand, contact and body keep their energy as
 * a symplectic step does (docs/design/moving.md). Weight F_w, suspension and floor move it by the implicit midpoint
 * rule. With q_m = (q + q+) / 2 the last equation is Cayley's map: it keeps |q| and, where no moment acts, the angular
 * momentum R J w; energies that are squares of p and q (gravity, suspension, floor) change by exactly what V_m does
 * against their forces there (Simo and Wong 1991).
 */
#include "haptable_body.h"

#include <stddef.h>

#include "haptable_six.h"
#include "haptable_surface.h"

#define DT HAPTABLE_BODY_TICK_S

/* (m/s)^2: a point on the floor that is slower does not slip. */
#define AT_REST2 1e-24f

/* A (V_m - V) = b of six unknowns: velocity and spin, body axes. A is symmetric: its lower half, and holds a mass, so
 * that no pivot is 0. */
struct system {
    float a[6][6];
    float b[6];
    float before[6]; /* V */
    int is_turned;   /* 1: suspension or floor may act on it */
    int is_bent;     /* 1: the suspension turns it back */
};

/* The frame of a tick: rows are world axes in body axes. */
struct frame {
    float row[3][3];
};

static struct frame frame_of(const float q[4]) {
    struct frame f;
    const float w = q[0], x = q[1], y = q[2], z = q[3];
    f.row[0][0] = 1.0f - 2.0f * (y * y + z * z);
    f.row[0][1] = 2.0f * (x * y - w * z);
    f.row[0][2] = 2.0f * (x * z + w * y);
    f.row[1][0] = 2.0f * (x * y + w * z);
    f.row[1][1] = 1.0f - 2.0f * (x * x + z * z);
    f.row[1][2] = 2.0f * (y * z - w * x);
    f.row[2][0] = 2.0f * (x * z - w * y);
    f.row[2][1] = 2.0f * (y * z + w * x);
    f.row[2][2] = 1.0f - 2.0f * (x * x + y * y);
    return f;
}

static void to_world(const struct frame* f, const float in[3], float out[3]) {
    for (int i = 0; i < 3; ++i) out[i] = vec_dot(f->row[i], in);
}

static void to_body(const struct frame* f, const float in[3], float out[3]) {
    for (int i = 0; i < 3; ++i) out[i] = f->row[0][i] * in[0] + f->row[1][i] * in[1] + f->row[2][i] * in[2];
}

/* q (s, v) */
static void quaternion_product(const float q[4], float s, const float v[3], float out[4]) {
    float across[3];
    vec_cross(q + 1, v, across);
    out[0] = q[0] * s - vec_dot(q + 1, v);
    out[1] = q[0] * v[0] + s * q[1] + across[0];
    out[2] = q[0] * v[1] + s * q[2] + across[1];
    out[3] = q[0] * v[2] + s * q[3] + across[2];
}

/* The turn in the middle of a tick with that spin: q_m (1 - dt/4 w) = q. */
static void middle_turn(const float q[4], const float spin[3], float middle[4]) {
    const float quarter = 0.25f * DT;
    float half_way[3];
    for (int i = 0; i < 3; ++i) half_way[i] = quarter * spin[i];
    const float scale = 1.0f / (1.0f + vec_dot(half_way, half_way));
    quaternion_product(q, 1.0f, half_way, middle);
    for (int i = 0; i < 4; ++i) middle[i] *= scale;
}

static void add_whole_vector(const float part[3], float sum[3], float low[3]) {
    for (int i = 0; i < 3; ++i) add_whole(part[i], &sum[i], &low[i]);
}

/* J x = b of the inertia, by J = L D L^T. */
static void solve_inertia(const struct haptable_body* body, const float b[3], float x[3]) {
    const float* j = body->inertia_kg_m2;
    const float l10 = j[3] / j[0];
    const float l20 = j[5] / j[0];
    const float d1 = j[1] - l10 * j[3];
    const float l21 = (j[4] - l20 * j[3]) / d1;
    const float d2 = j[2] - l20 * j[5] - l21 * l21 * d1;
    const float b1 = b[1] - l10 * b[0];
    x[2] = (b[2] - l20 * b[0] - l21 * b1) / d2;
    x[1] = b1 / d1 - l21 * x[2];
    x[0] = b[0] / j[0] - l10 * x[1] - l20 * x[2];
}

/* ---- the six equations ---------------------------------------------------------------------------------------- */

static float line_speed(const float n[3], const float turn[3], const float motion[6]) {
    return vec_dot(n, motion) + vec_dot(turn, motion + 3);
}

/* What acts along a line with the direction n, and with the lever `turn` about the centre, both body axes: a force, and
 * a resistance (N s/m) to the body's velocity there. */
static void add_line(struct system* s, const float n[3], const float turn[3], float force, float resistance) {
    const float now = force - resistance * line_speed(n, turn, s->before);
    float j[6];
    vec_copy(n, j);
    vec_copy(turn, j + 3);
    for (int r = 0; r < 6; ++r) {
        const float part = resistance * j[r];
        for (int c = 0; c <= r; ++c) s->a[r][c] += part * j[c];
        s->b[r] += now * j[r];
    }
}

/* ---- what acts on the body ------------------------------------------------------------------------------------ */

/* Motion, gravity and what suspends the body. A spring of stiffness k resists as k dt/2 in the middle of the tick. */
static void add_body(const struct haptable_body* body, const struct haptable_body_state* state, const struct frame* f,
                     struct system* s) {
    static const float no_lever[3] = {0.0f, 0.0f, 0.0f};
    const float rate = 2.0f / DT;
    const float* inertia = body->inertia_kg_m2;
    float weight[3];
    to_body(f, body->gravity_m_per_s2, weight);
    for (int i = 0; i < 3; ++i) {
        s->a[i][i] += rate * body->mass_kg;
        s->b[i] += body->mass_kg * weight[i];
        s->a[3 + i][3 + i] += rate * inertia[i] + body->turn_damping_n_m_s[i] + 0.5f * DT * body->turn_stiffness_n_m[i];
        s->b[3 + i] -= body->turn_damping_n_m_s[i] * s->before[3 + i];
    }
    s->a[4][3] += rate * inertia[3];
    s->a[5][4] += rate * inertia[4];
    s->a[5][3] += rate * inertia[5];
    for (int i = 0; i < 3; ++i) {
        const float k = body->stiffness_n_per_m[i];
        const float resistance = body->damping_n_s_per_m[i] + 0.5f * DT * k;
        const float stretch = (state->position_m[i] - body->centre_m[i]) - state->position_low_m[i];
        if (resistance > 0.0f) add_line(s, f->row[i], no_lever, -k * stretch, resistance);
    }
}

/* ---- the floor ------------------------------------------------------------------------------------------------ */

static uint32_t points_of(const struct haptable_body* body) {
    return body->point_count < HAPTABLE_BODY_POINTS ? body->point_count : HAPTABLE_BODY_POINTS;
}

/* What the floor does to one point in this tick. */
struct touch {
    float turn[3][3]; /* levers about the centre of the floor's axes, body axes */
    float gap_m;      /* over the floor, at the tick's begin */
    float damping;    /* N s/m: the floor's, and more while it owes */
    float push_n;     /* up, less resistance x speed */
    float resistance; /* of the speed up */
    float hold_n[2];  /* along the floor, less hold x speed */
    float hold;       /* 0: the point slips */
    float most_n;     /* that friction gives: by how the floor carried it in the last tick */
    float way[2];     /* in which it slips, length 1 */
    uint8_t carries;  /* 0: the floor does nothing */
    uint8_t slips;
};

/* Directions of the floor, body axes: up, and two along it. */
struct floor_axes {
    float axis[3][3];
};

static struct floor_axes floor_axes_of(const struct haptable_body* body, const struct frame* f) {
    struct floor_axes axes;
    to_body(f, body->floor_normal, axes.axis[0]); /* cppcheck-suppress uninitvar ; it is written here */
    to_body(f, body->floor_along, axes.axis[1]);
    vec_cross(axes.axis[0], axes.axis[1], axes.axis[2]);
    return axes;
}

/* Gaps at the tick's begin; levers as they are in its middle, so that what a point moves by is not its tangent's. */
static void find_gaps(const struct haptable_body* body, const struct haptable_body_state* state,
                      const struct floor_axes* floor, struct touch touch[]) {
    const float height =
        vec_dot(body->floor_normal, state->position_m) - vec_dot(body->floor_normal, state->position_low_m);
    float q[4];
    middle_turn(state->turn, state->spin_rad_per_s, q);
    const struct frame middle = frame_of(q);
    const struct floor_axes turned = floor_axes_of(body, &middle);
    for (uint32_t i = 0; i < points_of(body); ++i) {
        float arm[3];
        vec_sub(body->point_m[i], body->centre_m, arm);
        for (int c = 0; c < 3; ++c) vec_cross(arm, turned.axis[c], touch[i].turn[c]);
        touch[i].gap_m = (height - body->floor_m) + vec_dot(floor->axis[0], arm);
    }
}

/* A point in the floor is pushed out by half of k (gap + gap at the end); one that enters in this tick, at the fraction
 * 1 - part of it, by part of that and from 0: then energy changes by what the push does (a discrete gradient). */
static void press(const struct haptable_body* body, float speed, struct touch* touch) {
    const float k = body->floor_stiffness_n_per_m;
    const float c = touch->damping;
    const float end_m = touch->gap_m + DT * speed;
    touch->carries = touch->gap_m < 0.0f || end_m < 0.0f;
    if (!touch->carries) return;
    if (touch->gap_m < 0.0f) {
        touch->push_n = -k * touch->gap_m;
        touch->resistance = 0.5f * DT * k + c;
    } else {
        const float part = end_m / (end_m - touch->gap_m);
        touch->push_n = -0.5f * part * k * touch->gap_m;
        touch->resistance = part * (0.5f * DT * k + c);
    }
}

/* The floor's springs along it hold a point where it is, or friction brakes it on its way. */
static void hold(const struct haptable_body* body, const float stretch_m[2], struct touch* touch) {
    const float k = body->floor_stiffness_n_per_m;
    touch->hold = touch->slips ? 0.0f : 0.5f * DT * k + touch->damping;
    touch->hold_n[0] = touch->slips ? -touch->most_n * touch->way[0] : -k * stretch_m[0];
    touch->hold_n[1] = touch->slips ? -touch->most_n * touch->way[1] : -k * stretch_m[1];
}

static float length2(const float v[2]) { return v[0] * v[0] + v[1] * v[1]; }

static void set_way(const float along[2], float sign, struct touch* touch) {
    const float scale = sign * vec_inverse_root(length2(along));
    touch->way[0] = scale * along[0];
    touch->way[1] = scale * along[1];
}

/* By so much the floor damps more until it has taken back what it gave. */
#define OWING 4.0f

/* How the point begins the tick: as it was in the last one. speed: up and along the floor. */
static void begin_touch(const struct haptable_body* body, const struct haptable_body_state* state, uint32_t i,
                        const float speed[3], struct touch* touch) {
    touch->damping = (state->floor_owed_j > 0.0f ? OWING : 1.0f) * body->floor_damping_n_s_per_m;
    touch->most_n = body->floor_friction * state->push_n[i];
    touch->slips = (uint8_t)((state->slips >> i & 1u) != 0 && length2(speed + 1) > AT_REST2);
    if (touch->slips) set_way(speed + 1, 1.0f, touch);
    press(body, speed[0], touch);
    hold(body, state->stretch_m[i], touch);
}

/* A point that the floor would pull is let go; one that would need more than friction to be held slips, and one that
 * friction has brought to rest is held. speed: in the middle of the tick as it was tried. */
static void change_touch(const struct haptable_body* body, const float stretch_m[2], const float speed[3],
                         struct touch* touch) {
    float along_n[2];
    if (touch->gap_m >= 0.0f) press(body, speed[0], touch);
    if (!touch->carries) return;
    if (!(touch->push_n - touch->resistance * speed[0] > 0.0f)) {
        touch->carries = 0;
        return;
    }
    along_n[0] = touch->hold_n[0] - touch->hold * speed[1];
    along_n[1] = touch->hold_n[1] - touch->hold * speed[2];
    if (touch->slips) {
        touch->slips = touch->way[0] * speed[1] + touch->way[1] * speed[2] > 0.0f;
    } else if (length2(along_n) > touch->most_n * touch->most_n && length2(along_n) > HAPTABLE_NO_FORCE2) {
        touch->slips = 1;
        set_way(along_n, -1.0f, touch);
    }
    hold(body, stretch_m, touch);
}

static void add_floor(const struct haptable_body* body, const struct floor_axes* floor, const struct touch touch[],
                      struct system* s) {
    for (uint32_t i = 0; i < points_of(body); ++i) {
        const struct touch* t = &touch[i];
        if (!t->carries) continue;
        add_line(s, floor->axis[0], t->turn[0], t->push_n, t->resistance);
        if (!(body->floor_friction > 0.0f)) continue; /* nothing along it */
        add_line(s, floor->axis[1], t->turn[1], t->hold_n[0], t->hold);
        add_line(s, floor->axis[2], t->turn[2], t->hold_n[1], t->hold);
    }
}

/* No spring along the floor is stretched by more than friction holds: what it had stored beyond is lost. */
static void limit_stretch(float most_m, float stretch_m[2]) {
    const float size2 = stretch_m[0] * stretch_m[0] + stretch_m[1] * stretch_m[1];
    if (!(size2 > most_m * most_m)) return;
    const float scale = size2 > HAPTABLE_ROOT_LEAST ? most_m * vec_inverse_root(size2) : 0.0f;
    stretch_m[0] *= scale;
    stretch_m[1] *= scale;
}

static void speeds_of(const struct floor_axes* floor, const struct touch* touch, const float motion[6],
                      float speed[3]) {
    for (int c = 0; c < 3; ++c) speed[c] = line_speed(floor->axis[c], touch->turn[c], motion);
}

/* What a point's springs hold, times 2 / k. */
static float stored2(float gap_m, const float stretch_m[2]) {
    return (gap_m < 0.0f ? gap_m * gap_m : 0.0f) + length2(stretch_m);
}

/* What the next tick is to know of one point. Returns the energy that the floor gave to it beyond what it had stored:
 * below 0, but where a point enters or begins to slip otherwise than was tried. */
static float leave_point(const struct haptable_body* body, const struct touch* t, const float speed[3],
                         float stretch_m[2], float* push_n) {
    const float before2 = stored2(t->gap_m, stretch_m);
    float work = 0.0f;
    *push_n = t->carries ? t->push_n - t->resistance * speed[0] : 0.0f;
    for (int c = 0; c < 2; ++c) {
        if (t->carries && body->floor_friction > 0.0f) work += (t->hold_n[c] - t->hold * speed[1 + c]) * speed[1 + c];
        stretch_m[c] = t->carries ? stretch_m[c] + DT * speed[1 + c] : 0.0f;
    }
    if (t->carries) limit_stretch(t->most_n / body->floor_stiffness_n_per_m, stretch_m);
    return 0.5f * body->floor_stiffness_n_per_m * (stored2(t->gap_m + DT * speed[0], stretch_m) - before2) +
           DT * (work + *push_n * speed[0]);
}

/* The same of all. */
static float leave_floor(const struct haptable_body* body, const struct floor_axes* floor, const struct touch touch[],
                         const float motion[6], struct haptable_body_state* state) {
    float made_j = 0.0f;
    state->on_floor = 0;
    state->slips = 0;
    for (uint32_t i = 0; i < points_of(body); ++i) {
        float speed[3], push_n;
        speeds_of(floor, &touch[i], motion, speed);
        made_j += leave_point(body, &touch[i], speed, state->stretch_m[i], &push_n);
        state->push_n[i] = push_n > 0.0f ? push_n : 0.0f;
        if (!touch[i].carries) continue;
        state->on_floor |= (uint8_t)(1u << i);
        state->slips |= (uint8_t)((touch[i].slips ? 1u : 0u) << i);
    }
    return made_j;
}

/* ---- the tick ------------------------------------------------------------------------------------------------- */

/* r^T v - v, where r is the turn of the tick: that of the quaternion (1, a)^2 / (1 + a^2), a = dt/4 w_m. It keeps what
 * of v lies along w_m, so that the energy of motion is kept with the momentum. */
static void turn_back(const float a[3], const float v[3], float out[3]) {
    const float a2 = vec_dot(a, a);
    const float scale = 1.0f / ((1.0f + a2) * (1.0f + a2));
    float across[3], twice[3];
    vec_cross(a, v, across);
    vec_cross(a, across, twice);
    for (int i = 0; i < 3; ++i) out[i] = scale * (8.0f * twice[i] - 4.0f * (1.0f - a2) * across[i]);
}

/* v turned by half of that, or back where sign is -1: less v. */
static void turn_half(const float a[3], float sign, const float v[3], float out[3]) {
    const float scale = 2.0f / (1.0f + vec_dot(a, a));
    float across[3], twice[3];
    vec_cross(a, v, across);
    vec_cross(a, across, twice);
    for (int i = 0; i < 3; ++i) out[i] = scale * (twice[i] + sign * across[i]);
}

static void quarter_of(const float spin[3], float a[3]) {
    vec_zero(a);
    vec_add_scaled(0.25f * DT, spin, a);
}

/* What does not depend linearly on the motion in the middle: the suspension's moment, whose energy is 2 sum k_i q_i^2,
 * beyond what add_body has of it. */
static void bend(const struct haptable_body* body, const float q[4], const float motion[6], const float before[6],
                 float b[6]) {
    const float* k = body->turn_stiffness_n_m;
    float middle[4], pull[3], across[3];
    middle_turn(q, motion + 3, middle);
    for (int i = 0; i < 3; ++i) pull[i] = k[i] * middle[1 + i];
    vec_cross(pull, middle + 1, across);
    for (int i = 0; i < 3; ++i) {
        const float moment = -2.0f * (middle[0] * pull[i] + across[i]);
        b[3 + i] += moment + 0.5f * DT * k[i] * (motion[3 + i] - before[3 + i]);
    }
}

/* How the turn of the tick bends momentum and moment as the body has them: (r^T J w - J w) / dt + h^T T - T, h being
 * half of r. T: what acted in the round before. */
static void turn_momentum(const struct haptable_body* body, const float spin[3], const float middle[3],
                          const float moment[3], float bent[3]) {
    float momentum[3], a[3], half[3];
    quarter_of(middle, a);
    vec_symmetric_product(body->inertia_kg_m2, spin, momentum);
    turn_back(a, momentum, bent);
    turn_half(a, -1.0f, moment, half);
    vec_scale(1.0f / DT, bent);
    vec_add(bent, half, bent);
}

static int are_equal(const float a[3], const float b[3]) { return a[0] == b[0] && a[1] == b[1] && a[2] == b[2]; }

/* The fastest spin that find_free_spin takes, in quarters of a tick's turn: 2000 rad/s. */
#define FREE_TURN2 0.25f

/* Newton's step for J w_m = J w - c w_m x J w_m, c = dt/2 / (1 - a^2), a = dt/4 w_m: w_m -= K^-1 left, K = J +
 * c ([w_m]x J - [J w_m]x) + (w_m x J w_m) (dc/dw_m)^T. j: J over its trace, so that no product of three is too small.
 */
static void step_free_spin(const float j[6], const float before[3], float a2, float spin[3]) {
    const float column[3][3] = {{j[0], j[3], j[5]}, {j[3], j[1], j[4]}, {j[5], j[4], j[2]}};
    const float c = 0.5f * DT / (1.0f - a2);
    const float slope = 0.25f * DT * c * c;
    float along[3], bent[3], left[3], gained[3], k[3][3], across[3][3];
    vec_symmetric_product(j, spin, along);
    vec_cross(spin, along, bent);
    vec_sub(spin, before, gained);
    vec_symmetric_product(j, gained, left);
    vec_add_scaled(c, bent, left);
    for (int b = 0; b < 3; ++b) { /* columns of K */
        const float unit[3] = {b == 0 ? 1.0f : 0.0f, b == 1 ? 1.0f : 0.0f, b == 2 ? 1.0f : 0.0f};
        float turned[3], swept[3];
        vec_cross(spin, column[b], turned);
        vec_cross(unit, along, swept);
        for (int i = 0; i < 3; ++i) k[b][i] = column[b][i] + c * (turned[i] + swept[i]) + slope * spin[b] * bent[i];
    }
    for (int b = 0; b < 3; ++b) vec_cross(k[next_corner(b)], k[previous_corner(b)], across[b]);
    const float by = 1.0f / vec_dot(k[0], across[0]);
    for (int b = 0; b < 3; ++b) spin[b] -= by * vec_dot(across[b], left);
}

/* The spin in the middle of a tick in which nothing turns the body: the fixed point of the rounds below, which a
 * slender body that spins fast is far from after so few. Returns 0, and leaves the spin, where that is too fast. */
static int find_free_spin(const struct haptable_body* body, const float before[3], float spin[3]) {
    const float* inertia = body->inertia_kg_m2;
    const float scale = 1.0f / (inertia[0] + inertia[1] + inertia[2]);
    float j[6], found[3], was[3];
    for (int i = 0; i < 6; ++i) j[i] = scale * inertia[i];
    vec_copy(before, found);
    for (int round = 0; round < HAPTABLE_BODY_ROUNDS; ++round) {
        float a[3];
        quarter_of(found, a);
        const float a2 = vec_dot(a, a);
        if (!(a2 < FREE_TURN2)) return 0;
        vec_copy(found, was);
        step_free_spin(j, before, a2, found);
        if (are_equal(found, was)) break;
    }
    vec_copy(found, spin);
    return 1;
}

/* V_m of the system, from a first guess, and the moment T that acts then: in rounds, until one changes no bit of what
 * the next begins with. before: six_factor. */
static void find_middle(const struct haptable_body* body, const float q[4], const struct system* s, float motion[6],
                        float moment[3]) {
    float change[6], b[6], bent[3], spin[3], was[3];
    vec_zero(moment);
    if (!s->is_turned && find_free_spin(body, s->before + 3, motion + 3)) {
        six_solve(s->a, s->b, change);
        for (int i = 0; i < 3; ++i) motion[i] = s->before[i] + change[i];
        return;
    }
    for (int round = 0; round < HAPTABLE_BODY_ROUNDS; ++round) {
        vec_copy(motion + 3, spin);
        vec_copy(moment, was);
        for (int i = 0; i < 6; ++i) b[i] = s->b[i];
        if (s->is_bent) bend(body, q, motion, s->before, b);
        turn_momentum(body, s->before + 3, motion + 3, moment, bent);
        vec_add_scaled(1.0f, bent, b + 3);
        six_solve(s->a, b, change);
        for (int i = 0; i < 6; ++i) motion[i] = s->before[i] + change[i];
        if (s->is_turned) {
            vec_symmetric_product(body->inertia_kg_m2, change + 3, moment);
            for (int i = 0; i < 3; ++i) moment[i] = moment[i] * (2.0f / DT) - bent[i];
        }
        if (are_equal(spin, motion + 3) && are_equal(was, moment)) return;
    }
}

/* The floor's points are tried as they were in the last tick, then taken as that motion changes them. */
static void add_touches(const struct haptable_body* body, const struct haptable_body_state* state,
                        const struct floor_axes* floor, float motion[6], struct system* s, struct touch touch[]) {
    struct system trial = *s;
    float moment[3], speed[3];
    find_gaps(body, state, floor, touch);
    for (uint32_t i = 0; i < points_of(body); ++i) {
        speeds_of(floor, &touch[i], motion, speed);
        begin_touch(body, state, i, speed, &touch[i]);
    }
    add_floor(body, floor, touch, &trial);
    six_factor(trial.a);
    find_middle(body, state->turn, &trial, motion, moment);
    for (uint32_t i = 0; i < points_of(body); ++i) {
        speeds_of(floor, &touch[i], motion, speed);
        change_touch(body, state->stretch_m[i], speed, &touch[i]);
    }
    add_floor(body, floor, touch, s);
}

/* Momentum after the tick: weight acts along world axes, and what suspension and floor did beside it where the body was
 * in the middle of the tick. */
static void push(const struct haptable_body* body, const struct frame* f, const struct system* s, const float motion[6],
                 const float moment[3], struct haptable_body_state* state) {
    float gained[3], along[3];
    for (int i = 0; i < 3; ++i) gained[i] = DT * body->gravity_m_per_s2[i];
    if (s->is_turned) {
        float weight[3], a[3];
        to_body(f, gained, weight);
        for (int i = 0; i < 3; ++i) along[i] = 2.0f * (motion[i] - s->before[i]) - weight[i];
        to_world(f, along, weight);
        vec_add_scaled(1.0f, weight, gained);
        quarter_of(motion + 3, a);
        turn_half(a, 1.0f, moment, along);
        vec_add_scaled(1.0f, moment, along);
        to_world(f, along, weight);
        vec_scale(DT, weight);
        add_whole_vector(weight, state->momentum_n_m_s, state->momentum_low_n_m_s);
    }
    for (int i = 0; i < 3; ++i)
        along[i] = DT * ((state->velocity_m_per_s[i] - state->velocity_low_m_per_s[i]) + 0.5f * gained[i]);
    add_whole_vector(along, state->position_m, state->position_low_m);
    add_whole_vector(gained, state->velocity_m_per_s, state->velocity_low_m_per_s);
}

/* q += dt/2 q_m (0, w), kept at length 1. */
static void turn(const float spin[3], struct haptable_body_state* state) {
    float middle[4], change[4];
    middle_turn(state->turn, spin, middle);
    quaternion_product(middle, 0.0f, spin, change);
    const float longer = 0.5f * (1.0f - (state->turn[0] * state->turn[0] + vec_dot(state->turn + 1, state->turn + 1)));
    for (int i = 0; i < 4; ++i)
        add_whole(0.5f * DT * change[i] + longer * state->turn[i], &state->turn[i], &state->turn_low[i]);
}

/* w = J^-1 R^T L */
static void find_spin(const struct haptable_body* body, struct haptable_body_state* state) {
    const struct frame f = frame_of(state->turn);
    float momentum[3], along[3];
    vec_sub(state->momentum_n_m_s, state->momentum_low_n_m_s, momentum);
    to_body(&f, momentum, along);
    solve_inertia(body, along, state->spin_rad_per_s);
}

void haptable_body_init(const struct haptable_body* body, struct haptable_body_state* state) {
    static const struct haptable_body_state fresh = {.turn = {1.0f, 0.0f, 0.0f, 0.0f}};
    *state = fresh;
    vec_copy(body->centre_m, state->position_m);
}

void haptable_body_from_world(const struct haptable_body* body, const struct haptable_body_state* state,
                              const float world_m[3], float body_m[3]) {
    const struct frame f = frame_of(state->turn);
    float offset[3];
    vec_sub(world_m, state->position_m, offset);
    to_body(&f, offset, body_m);
    vec_add_scaled(1.0f, body->centre_m, body_m);
}

void haptable_body_to_world(const struct haptable_body_state* state, const float along_body[3], float along_world[3]) {
    const struct frame f = frame_of(state->turn);
    to_world(&f, along_body, along_world);
}

void haptable_body_kick(const struct haptable_body* body, struct haptable_body_state* state, const float at_m[3],
                        const float force_n[3]) {
    const struct frame f = frame_of(state->turn);
    float along[3], arm[3], part[3];
    vec_sub(at_m, body->centre_m, along);
    to_world(&f, along, arm);
    vec_cross(arm, force_n, part);
    vec_scale(DT, part);
    add_whole_vector(part, state->momentum_n_m_s, state->momentum_low_n_m_s);
    for (int i = 0; i < 3; ++i) part[i] = force_n[i] * (DT / body->mass_kg);
    add_whole_vector(part, state->velocity_m_per_s, state->velocity_low_m_per_s);
    find_spin(body, state);
}

void haptable_body_give(const struct haptable_body* body, const float at_m[3], const float force_n[3],
                        float moved_m[3]) {
    float arm[3], moment[3], spin[3];
    vec_sub(at_m, body->centre_m, arm);
    vec_cross(arm, force_n, moment);
    solve_inertia(body, moment, spin);
    vec_cross(spin, arm, moved_m);
    vec_add_scaled(1.0f / body->mass_kg, force_n, moved_m);
    vec_scale(DT * DT, moved_m);
}

/* 1 where anything but weight may act on the body. */
static int is_suspended(const struct haptable_body* body) {
    float any = 0.0f;
    for (int i = 0; i < 3; ++i)
        any += body->stiffness_n_per_m[i] + body->damping_n_s_per_m[i] + body->turn_stiffness_n_m[i] +
               body->turn_damping_n_m_s[i];
    return any > 0.0f;
}

static int is_carried(const struct haptable_body* body, const struct touch touch[]) {
    for (uint32_t i = 0; i < points_of(body); ++i)
        if (touch[i].carries) return 1;
    return 0;
}

void haptable_body_move(const struct haptable_body* body, struct haptable_body_state* state) {
    struct system s = {{{0.0f}}, {0.0f}, {0.0f}, 0, 0};
    struct touch touch[HAPTABLE_BODY_POINTS];
    const struct frame f = frame_of(state->turn);
    const struct floor_axes floor = floor_axes_of(body, &f);
    float motion[6], moment[3], velocity[3];
    vec_sub(state->velocity_m_per_s, state->velocity_low_m_per_s, velocity);
    to_body(&f, velocity, s.before);
    vec_copy(state->spin_rad_per_s, s.before + 3);
    for (int i = 0; i < 6; ++i) motion[i] = s.before[i];
    s.is_turned = is_suspended(body) || body->point_count != 0;
    s.is_bent = body->turn_stiffness_n_m[0] + body->turn_stiffness_n_m[1] + body->turn_stiffness_n_m[2] > 0.0f;
    add_body(body, state, &f, &s);
    if (body->point_count != 0) {
        add_touches(body, state, &floor, motion, &s, touch);
        s.is_turned = is_suspended(body) || is_carried(body, touch);
    }
    six_factor(s.a);
    find_middle(body, state->turn, &s, motion, moment);
    if (body->point_count != 0) {
        const float owed_j = state->floor_owed_j + leave_floor(body, &floor, touch, motion, state);
        state->floor_owed_j = owed_j > 0.0f ? owed_j : 0.0f;
    }
    push(body, &f, &s, motion, moment, state);
    turn(motion + 3, state);
    find_spin(body, state);
}

struct haptable_span haptable_span_of_body(const void* tables, uint32_t field) {
    const struct haptable_body* body = (const struct haptable_body*)tables;
    const struct haptable_span span = {body,
                                       field == 0u ? (uint32_t)offsetof(struct haptable_body, crc) : HAPTABLE_SPAN_END};
    return span;
}

const struct haptable_rigid_part haptable_part_rigid = {.init = haptable_body_init,
                                                        .from_world = haptable_body_from_world,
                                                        .to_world = haptable_body_to_world,
                                                        .give = haptable_body_give,
                                                        .kick = haptable_body_kick,
                                                        .move = haptable_body_move,
                                                        .span = haptable_span_of_body};
