// SPDX-License-Identifier: GPL-2.0-or-later
// The C side of the library: no exception leaves it.
#include <algorithm>
#include <exception>
#include <initializer_list>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "host/base/error.hpp"
#include "host/library/haptable_library.h"
#include "host/library/object.hpp"

namespace haptable {

namespace {

static_assert(sizeof(haptable_touch) == 92 && sizeof(haptable_wrench) == 132);
static_assert(int{HAPTABLE_TOUCH_SILENT} == HAPTABLE_SILENT && int{HAPTABLE_TOUCH_FREE} == HAPTABLE_FREE &&
              int{HAPTABLE_TOUCH_CONTACT} == HAPTABLE_CONTACT && int{HAPTABLE_TOUCH_REJECTED} == HAPTABLE_REJECTED &&
              int{HAPTABLE_TOUCH_LIMITED} == HAPTABLE_LIMITED && int{HAPTABLE_TOUCH_FAULTED} == HAPTABLE_FAULTED);
static_assert(int{HAPTABLE_TOUCH_GRAB} == HAPTABLE_BUTTON_GRAB &&
              int{HAPTABLE_TOUCH_ACKNOWLEDGE} == HAPTABLE_BUTTON_ACKNOWLEDGE);

thread_local std::string last_error;

/// What `work` returns, or `failed`, and why.
template <typename Work, typename Value>
Value guarded(Value failed, Work work) noexcept {
    try {
        return work();
    } catch (const std::bad_alloc&) {
        last_error.assign("out of memory");
    } catch (const std::exception& error) {
        try {
            last_error = error.what();
        } catch (...) {
            last_error.clear();
        }
    }
    return failed;
}

/// True, and why, where one of the pointers that a function was given and needs is NULL.
bool lacks(const char* function, std::initializer_list<const void*> needed) noexcept {
    if (std::find(needed.begin(), needed.end(), nullptr) == needed.end()) return false;
    return guarded(true, [&]() -> bool { throw Error(std::string(function) + ": a pointer that it needs is NULL"); });
}

#define HAPTABLE_COUNTER_NAME(name) #name,
constexpr const char* kCounter[] = {HAPTABLE_COUNTERS(HAPTABLE_COUNTER_NAME)};
#undef HAPTABLE_COUNTER_NAME

haptable_touch to_touch(const LoadedObject& object, const haptable_output& out) {
    haptable_touch touch{};
    touch.state = out.state;
    touch.faults = out.faults;
    for (std::size_t c = 0; c < 3; ++c) touch.node[c] = object.node_of(out.vertex[c]);
    std::copy_n(out.alpha, 3, touch.alpha);
    std::copy_n(out.god_object_m, 3, touch.god_object_m);
    std::copy_n(out.force_n, 3, touch.force_n);
    std::copy_n(&out.nodal_force_n[0][0], 9, &touch.nodal_force_n[0][0]);
    return touch;
}

/// The choice of that word; `own` where there is none. Throws Error for another word.
template <typename Choice>
Choice choice(const char* text, Choice own) {
    if (text == nullptr) return own;
    if (const std::optional<Choice> chosen = choice_of<Choice>(text)) return *chosen;
    std::string all;
    for (const char* word : words(Choice{})) all += (all.empty() ? "" : ", ") + std::string(word);
    throw Error(std::string(text) + ": is none of " + all);
}

constexpr double kNoForce_n = 1e14;  // that a servo without limits would cut; its square is a float

SceneFiles with_options(SceneFiles files, const haptable_object_options& options) {
    files.tables.precision = choice(options.precision, files.tables.precision);
    files.tables.god_object = choice(options.god_object, files.tables.god_object);
    if (options.is_bare == 0) return files;
    files.tables.limits = {};
    files.tables.max_force_n = kNoForce_n;
    files.tables.options.set("contact.release_slew", 0.0);
    return files;
}

/// What a touch loads, or a dent that the finger left; nothing without either. Throws Error for nodes that are none of
/// the mesh's.
std::vector<NodalForce> loads_of(const haptable_touch& touch, std::size_t node_count) {
    std::vector<NodalForce> loads;
    if (touch.node[0] < 0) return loads;
    for (std::size_t c = 0; c < 3; ++c) {
        if (touch.node[c] < 0 || static_cast<std::size_t>(touch.node[c]) >= node_count)
            throw Error("the touch is of another object: it names node " + std::to_string(touch.node[c]));
        loads.push_back({touch.node[c], std::to_array(touch.nodal_force_n[c])});
    }
    return loads;
}

/// row: null for all.
std::span<const std::uint32_t> rows_of(const LoadedObject& loaded, const std::uint32_t* row, std::size_t count) {
    if (row == nullptr && count != loaded.rows())
        throw Error("there are " + std::to_string(loaded.rows()) + " rows, not " + std::to_string(count));
    return row == nullptr ? std::span<const std::uint32_t>() : std::span(row, count);
}

haptable_pose to_pose(const SceneState& state) {
    haptable_pose pose{};
    pose.turn[0] = 1.0F;
    const haptable_body_state* const at = state.touched();
    if (at == nullptr) return pose;
    std::copy_n(state.scene().body->centre_m, 3, pose.rest_centre_m);
    std::copy_n(at->position_m, 3, pose.centre_m);
    std::copy_n(at->turn, 4, pose.turn);
    std::copy_n(at->velocity_m_per_s, 3, pose.velocity_m_per_s);
    std::copy_n(at->spin_rad_per_s, 3, pose.spin_rad_per_s);
    pose.on_floor = at->on_floor;
    return pose;
}

void copy_swung(const SceneState& state, float* swung) {
    if (state.modes() != nullptr) std::copy_n(state.modes()->q, state.scene().modes->count, swung);
}

/// The finger at that position, with the buttons that are held down; null: it is away.
haptable_input input_of(const float* position_m, std::uint32_t buttons) {
    haptable_input in{{0.0F, 0.0F, 0.0F}, buttons, 0};
    if (position_m == nullptr) return in;
    std::copy_n(position_m, 3, in.finger_m);
    in.is_there = 1;
    return in;
}

void note(const SceneState& state, const float* position_m, const haptable_output& out, EnergyAccount& energy) {
    if (position_m == nullptr) return energy.add({}, out);
    const std::array<float, 3> at_m{position_m[0], position_m[1], position_m[2]};
    energy.add(at_m, out, state.inside(at_m));
}

haptable_touch_energy to_energy(const EnergyAccount& energy) {
    return {energy.stored_j(), energy.most_stored_j(), energy.given_j(), energy.most_given_j()};
}

std::uint32_t counter_of(const haptable_counters& c, std::uint32_t counter) {
#define HAPTABLE_COUNTER_VALUE(name) c.name,
    const std::uint32_t values[] = {HAPTABLE_COUNTERS(HAPTABLE_COUNTER_VALUE)};
#undef HAPTABLE_COUNTER_VALUE
    return counter < std::size(values) ? values[counter] : 0;
}

/// A servo without contact, its tables checked.
template <typename Servo>
Servo* begin(const haptable_object& object, const haptable_pair_model* pair,
             const haptable_tool_model* tool = nullptr) {
    const LoadedScene& scene = object.loaded->scene();
    auto* servo = new Servo{{object.loaded, {scene.model(), pair, scene.body(), scene.modes(), tool}}};
    servo->state.check(HAPTABLE_CHECK_ALL);
    return servo;
}

/// position_m, touch: of each finger; a position is null where the finger is away.
void step(Touching& servo, const float* const position_m[], std::uint32_t now_us, haptable_touch touch[]) {
    haptable_input in[HAPTABLE_HANDS]{};
    haptable_output out[HAPTABLE_HANDS]{};
    for (std::size_t f = 0; f < servo.state.fingers(); ++f) in[f] = input_of(position_m[f], servo.buttons[f]);
    servo.state.step(in, now_us, out);
    for (std::size_t f = 0; f < servo.state.fingers(); ++f) {
        note(servo.state, position_m[f], out[f], servo.energy[f]);
        touch[f] = to_touch(*servo.loaded, out[f]);
    }
}

}  // namespace

}  // namespace haptable

using haptable::guarded;
using haptable::lacks;

std::uint32_t haptable_library_version(void) { return HAPTABLE_LIBRARY_VERSION; }

const char* haptable_library_error(void) { return haptable::last_error.c_str(); }

haptable_object* haptable_object_load(const char* folder, std::uint64_t tables_hash) {
    if (lacks(__func__, {folder})) return nullptr;
    return guarded(static_cast<haptable_object*>(nullptr), [&] {
        return new haptable_object{
            std::make_shared<const haptable::LoadedObject>(haptable::TablesFolder(folder), tables_hash)};
    });
}

haptable_object* haptable_object_load_as(const char* folder, const haptable_object_options* options) {
    if (lacks(__func__, {folder, options})) return nullptr;
    return guarded(static_cast<haptable_object*>(nullptr), [&] {
        return new haptable_object{std::make_shared<const haptable::LoadedObject>(
            haptable::with_options(haptable::read_scene_files(haptable::TablesFolder(folder)), *options))};
    });
}

void haptable_object_free(haptable_object* object) { delete object; }

haptable_object_facts haptable_object_describe(const haptable_object* object) {
    haptable_object_facts facts{};
    facts.name = "";
    if (lacks(__func__, {object})) return facts;
    const haptable::LoadedObject& loaded = *object->loaded;
    const haptable::Tables& tables = loaded.tables();
    facts.name = tables.name.c_str();
    facts.tables_hash = loaded.scene().model().hash;
    facts.max_force_n = loaded.scene().model().max_force_n;
    facts.stiffness_n_per_m = loaded.scene().model().stiffness_limit_n_per_m;
    facts.node_count = static_cast<std::uint32_t>(tables.position.size());
    facts.surface_count = static_cast<std::uint32_t>(tables.surface.size());
    facts.patch_count = static_cast<std::uint32_t>(tables.patch.size());
    facts.row_count = static_cast<std::uint32_t>(loaded.rows());
    // std::array<T, 3> has the layout of T[3].
    facts.rest_m = reinterpret_cast<const double(*)[3]>(tables.position.data());
    facts.surface = reinterpret_cast<const std::int32_t(*)[3]>(tables.surface.data());
    facts.patch = reinterpret_cast<const std::int32_t(*)[3]>(tables.patch.data());
    facts.row_node = tables.row_id.data();
    return facts;
}

int haptable_object_deform(const haptable_object* object, const haptable_touch* touch, const std::uint32_t* row,
                           std::size_t count, float (*displacement_m)[3]) {
    if (lacks(__func__, {object, touch}) || (count > 0 && lacks(__func__, {displacement_m}))) return -1;
    return guarded(-1, [&] {
        const haptable::LoadedObject& loaded = *object->loaded;
        const auto rows = haptable::rows_of(loaded, row, count);
        if (row != nullptr && count == 0) return 0;
        loaded.deform(haptable::loads_of(*touch, loaded.tables().position.size()), rows,
                      {&displacement_m[0][0], 3 * count});
        return 0;
    });
}

std::uint32_t haptable_object_modes(const haptable_object* object) {
    if (lacks(__func__, {object})) return 0;
    return object->loaded->scene().modes() != nullptr ? object->loaded->scene().modes()->count : 0;
}

int haptable_object_swing(const haptable_object* object, const float* swung, const std::uint32_t* row,
                          std::size_t count, float (*displacement_m)[3]) {
    if (lacks(__func__, {object}) || (count > 0 && lacks(__func__, {displacement_m}))) return -1;
    if (haptable_object_modes(object) > 0 && lacks(__func__, {swung})) return -1;
    return guarded(-1, [&] {
        const haptable::LoadedObject& loaded = *object->loaded;
        const auto rows = haptable::rows_of(loaded, row, count);
        if (row != nullptr && count == 0) return 0;
        loaded.swing({swung, haptable_object_modes(object)}, rows, {&displacement_m[0][0], 3 * count});
        return 0;
    });
}

haptable_finger* haptable_finger_new(const haptable_object* object) {
    if (lacks(__func__, {object})) return nullptr;
    return guarded(static_cast<haptable_finger*>(nullptr),
                   [&] { return haptable::begin<haptable_finger>(*object, nullptr); });
}

void haptable_finger_free(haptable_finger* finger) { delete finger; }

void haptable_finger_step(haptable_finger* finger, const float position_m[3], std::uint32_t now_us,
                          haptable_touch* touch) {
    if (lacks(__func__, {finger, touch})) return;
    haptable::step(*finger, &position_m, now_us, touch);
}

int haptable_finger_watch(haptable_finger* finger, std::uint32_t now_us, haptable_touch* touch) {
    if (lacks(__func__, {finger, touch})) return 0;
    haptable_output out;
    if (haptable_servo_watch(&finger->state.servo(0), now_us, &out) == 0) return 0;
    finger->energy[0].add({}, out);
    *touch = haptable::to_touch(*finger->loaded, out);
    return 1;
}

void haptable_finger_buttons(haptable_finger* finger, std::uint32_t buttons) {
    if (!lacks(__func__, {finger})) finger->buttons[0] = buttons;
}

void haptable_finger_replay(haptable_finger* finger, const float (*position_m)[3], std::size_t count,
                            std::uint32_t begin_us, haptable_touch* touch) {
    if (count > 0 && lacks(__func__, {finger, position_m, touch})) return;
    for (std::size_t i = 0; i < count; ++i)
        haptable_finger_step(finger, position_m[i], begin_us + static_cast<std::uint32_t>(i) * HAPTABLE_TICK_US,
                             &touch[i]);
}

haptable_touch_energy haptable_finger_energy(const haptable_finger* finger) {
    return lacks(__func__, {finger}) ? haptable_touch_energy{} : haptable::to_energy(finger->energy[0]);
}

void haptable_finger_swung(const haptable_finger* finger, float* swung) {
    if (!lacks(__func__, {finger, swung})) haptable::copy_swung(finger->state, swung);
}

haptable_pose haptable_finger_pose(const haptable_finger* finger) {
    return lacks(__func__, {finger}) ? haptable_pose{} : haptable::to_pose(finger->state);
}

int haptable_object_is_free(const haptable_object* object) {
    return !lacks(__func__, {object}) && object->loaded->scene().body() != nullptr ? 1 : 0;
}

std::uint32_t haptable_object_fingers(const haptable_object* object) {
    if (lacks(__func__, {object})) return 0;
    const haptable_pair_model* const pair = object->loaded->scene().pair();
    return pair != nullptr ? pair->finger_count : 1;
}

haptable_fingers* haptable_fingers_new(const haptable_object* object) {
    if (lacks(__func__, {object})) return nullptr;
    return guarded(static_cast<haptable_fingers*>(nullptr), [&] {
        if (object->loaded->scene().pair() == nullptr)
            throw haptable::Error(object->loaded->tables().name +
                                  " has one finger: write fingers = 2 in [contact] and make its tables again");
        return haptable::begin<haptable_fingers>(*object, object->loaded->scene().pair());
    });
}

void haptable_fingers_free(haptable_fingers* fingers) { delete fingers; }

void haptable_fingers_step(haptable_fingers* fingers, const float* const position_m[], std::uint32_t now_us,
                           haptable_touch touch[]) {
    if (lacks(__func__, {fingers, position_m, touch})) return;
    haptable::step(*fingers, position_m, now_us, touch);
}

void haptable_fingers_buttons(haptable_fingers* fingers, std::uint32_t finger, std::uint32_t buttons) {
    if (!lacks(__func__, {fingers}) && finger < fingers->state.fingers()) fingers->buttons[finger] = buttons;
}

void haptable_fingers_replay(haptable_fingers* fingers, const float (*position_m)[3], std::size_t count,
                             std::uint32_t begin_us, haptable_touch touch[]) {
    if (count > 0 && lacks(__func__, {fingers, position_m, touch})) return;
    const std::size_t of_tick = count > 0 ? fingers->state.fingers() : 0;
    for (std::size_t i = 0; i < count; ++i) {
        const float* each_m[HAPTABLE_HANDS]{};
        for (std::size_t f = 0; f < of_tick; ++f) each_m[f] = position_m[of_tick * i + f];
        haptable::step(*fingers, each_m, begin_us + static_cast<std::uint32_t>(i) * HAPTABLE_TICK_US,
                       touch + of_tick * i);
    }
}

haptable_touch_energy haptable_fingers_energy(const haptable_fingers* fingers, std::uint32_t finger) {
    if (lacks(__func__, {fingers}) || finger >= fingers->state.fingers()) return {};
    return haptable::to_energy(fingers->energy[finger]);
}

void haptable_fingers_swung(const haptable_fingers* fingers, float* swung) {
    if (!lacks(__func__, {fingers, swung})) haptable::copy_swung(fingers->state, swung);
}

haptable_pose haptable_fingers_pose(const haptable_fingers* fingers) {
    return lacks(__func__, {fingers}) ? haptable_pose{} : haptable::to_pose(fingers->state);
}

std::uint32_t haptable_fingers_counter(const haptable_fingers* fingers, std::uint32_t finger, std::uint32_t counter) {
    if (lacks(__func__, {fingers})) return 0;
    return finger < fingers->state.fingers() ? haptable::counter_of(fingers->state.servo(finger).counters, counter) : 0;
}

std::uint32_t haptable_library_counters(void) { return static_cast<std::uint32_t>(std::size(haptable::kCounter)); }

const char* haptable_library_counter_name(std::uint32_t counter) {
    return counter < haptable_library_counters() ? haptable::kCounter[counter] : nullptr;
}

std::uint32_t haptable_finger_counter(const haptable_finger* finger, std::uint32_t counter) {
    if (lacks(__func__, {finger})) return 0;
    return haptable::counter_of(finger->state.servo(0).counters, counter);
}

std::uint32_t haptable_object_points(const haptable_object* object) {
    if (lacks(__func__, {object})) return 0;
    const haptable_tool_model* const tool = object->loaded->scene().tool();
    return tool != nullptr ? tool->points.count : 0;
}

void haptable_object_tool(const haptable_object* object, float (*point_m)[3]) {
    const std::uint32_t count = haptable_object_points(object);
    if (count == 0 || lacks(__func__, {point_m})) return;
    std::copy_n(&object->loaded->scene().tool()->point_m[0][0], 3 * count, &point_m[0][0]);
}

haptable_held* haptable_held_new(const haptable_object* object) {
    if (lacks(__func__, {object})) return nullptr;
    return guarded(static_cast<haptable_held*>(nullptr), [&] {
        const haptable::LoadedScene& scene = object->loaded->scene();
        if (scene.tool() == nullptr)
            throw haptable::Error(object->loaded->tables().name +
                                  " has no tool: write [tool] in its scene and make its tables again");
        return haptable::begin<haptable_held>(*object, nullptr, scene.tool());
    });
}

void haptable_held_free(haptable_held* held) { delete held; }

void haptable_held_step(haptable_held* held, const float position_m[3], const float turn[4], std::uint32_t now_us,
                        haptable_wrench* wrench) {
    if (lacks(__func__, {held, position_m, turn, wrench})) return;
    haptable_tool_input in{haptable::input_of(position_m, held->buttons[0]), {}};
    std::copy_n(turn, 4, in.turn);
    haptable_tool_output out{};
    held->state.step(in, now_us, out);
    wrench->hand = haptable::to_touch(*held->loaded, out.hand);
    std::copy_n(out.torque_n_m, 3, wrench->torque_n_m);
    std::copy_n(out.position_m, 3, wrench->position_m);
    std::copy_n(out.turn, 4, wrench->turn);
}

void haptable_held_replay(haptable_held* held, const float (*position_m)[3], const float (*turn)[4], std::size_t count,
                          std::uint32_t begin_us, haptable_wrench* wrench) {
    if (count > 0 && lacks(__func__, {held, position_m, turn, wrench})) return;
    for (std::size_t i = 0; i < count; ++i)
        haptable_held_step(held, position_m[i], turn[i], begin_us + static_cast<std::uint32_t>(i) * HAPTABLE_TICK_US,
                           &wrench[i]);
}

int haptable_held_point(const haptable_held* held, std::uint32_t point, haptable_touch* touch) {
    if (lacks(__func__, {held, touch})) return -1;
    return guarded(-1, [&] {
        if (point >= held->state.tool()->points.count)
            throw haptable::Error("there is no point " + std::to_string(point) + " of the tool");
        *touch = haptable::to_touch(*held->loaded, held->state.point(point));
        return 0;
    });
}

void haptable_held_buttons(haptable_held* held, std::uint32_t buttons) {
    if (!lacks(__func__, {held})) held->buttons[0] = buttons;
}

std::uint32_t haptable_held_counter(const haptable_held* held, std::uint32_t counter) {
    return lacks(__func__, {held}) ? 0 : haptable::counter_of(held->state.servo(0).counters, counter);
}
