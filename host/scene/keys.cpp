// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/scene/keys.hpp"

#include "host/base/json.hpp"
#include "host/base/mass_range.hpp"
#include "host/base/tool_range.hpp"
#include "host/scene/device_models.hpp"

namespace haptable {

namespace {

using Json = nlohmann::ordered_json;
using enum KeyType;

// A million nodes: beyond that the factor does not fit into the memory of a workstation.
constexpr double kMostNodesPerSide = 100;

// A filled surface needs room for some tetrahedra.
constexpr double kFewestNodes = 20;

// The oldest force of a device that the watchdogs let pass.
constexpr double kMostDelay_s = 0.02;

constexpr double kMostAngle_deg = 180.0;

// HAPTABLE_MODES: the servo's state.
constexpr double kMostModes = 16;

/// Damping ratios of jelly and soft tissue: values of 0.03 to 0.3 are reported; 0.05 rings for some ten swings.
constexpr double kModeDamping = 0.05, kLeastModeDamping = 1e-4;

/// N/ms by which a jump of the least-energy god-object is brought down where the scene does not say: a step of 10 mN is
/// hardly felt, and a force of 1 N is gone in a tenth of a second.
constexpr double kReleaseOfJumps = 0.01;

// Where the scene does not say, what a desktop device and a hand are expected to keep to. A hand moves no faster than
// HAPTABLE_FAST_SEGMENT_M a tick.
constexpr double kMaxSpeed = 5.0;        // m/s
constexpr double kFullForceTime = 0.01;  // s, from none to max_force
constexpr double kRampTime = 1.0;        // s

constexpr auto kTables = Changes::kTables;

template <const Figure DeviceModel::*figure>
Json of_model(const SceneOptions& above) {
    return (find_device_model(above.text("device.model"))->*figure).value;
}

Json mass_of_model(const SceneOptions& above) {
    const double mass_kg = find_device_model(above.text("device.model"))->mass_kg.value;
    return {mass_kg, mass_kg, mass_kg};
}

/// All words of a choice.
template <typename Choice>
std::vector<const char*> words_of() {
    const auto all = words(Choice{});
    return {all.begin(), all.end()};
}

std::vector<const char*> model_names() {
    std::vector<const char*> names;
    for (const DeviceModel& model : device_models()) names.push_back(model.name);
    return names;
}

bool is_free(const SceneOptions& options) { return options.flag("body.free"); }

Json release_slew(const SceneOptions& above) {
    const bool jumps = above.text("contact.god_object") == "least-energy";  // from one minimum to another
    const bool has_points = above.has("tool") || above.integer("contact.fingers") > 2;
    return jumps && !is_free(above) && !has_points ? kReleaseOfJumps : 0.0;
}

Json max_force_rate(const SceneOptions& above) { return above.number("device.max_force") / kFullForceTime; }

Json mode_damping(const SceneOptions& above) { return above.integer("body.modes") > 0 ? Json(kModeDamping) : Json(); }

Json ramp_time(const SceneOptions& above) {
    return above.text("device.force_return") == "ramp" ? Json(kRampTime) : Json();
}

void add_where(std::vector<Key>& keys, const char* section) {
    keys.push_back({.section = section,
                    .name = "box",
                    .type = kBox,
                    .unit = "m",
                    .means = "a box: xmin, ymin, zmin, xmax, ymax, zmax"});
    keys.push_back({.section = section, .name = "group", .type = kText, .means = "or a named group of the mesh file"});
}

void add_material(std::vector<Key>& keys, const char* section) {
    const auto by_law = [&](const char* name, const char* unit, const char* means) {
        keys.push_back({.section = section, .name = name, .type = kByLaw, .unit = unit, .means = means});
    };
    keys.push_back({.section = section,
                    .name = "law",
                    .type = kWord,
                    .words = {"isotropic", "orthotropic", "fibre"},
                    .fallback = "isotropic",
                    .means = "the law of the material; the last two have [keys of their own](MATERIALS.md#keys)"});
    by_law("young", "Pa", "Young's modulus, or [E1, E2, E3]");
    by_law("poisson", "",
           "Poisson's ratio, above -1 and below 0.5, with linear tetrahedra at most 0.4999; or [nu12, nu13, nu23]");
    by_law("shear", "Pa", "[G12, G13, G23], or along the fibres");
    by_law("axes", "", "directions 1 and 2 of the material");
    by_law("axes_field", "", "or cell vectors of the mesh file");
    by_law("around", "m", "or an axis: a point and a direction");
    by_law("young_along", "Pa", "modulus along the fibres");
    by_law("young_across", "Pa", "modulus across them");
    by_law("poisson_across", "", "Poisson's ratio across the fibres");
    by_law("direction", "", "direction of the fibres");
    by_law("direction_field", "", "or a cell vector of the mesh file");
}

// A row is a key.
// clang-format off
std::vector<Key> make_keys() {
    std::vector<Key> keys;
    const auto add = [&](const char* section, std::initializer_list<Key> more) {
        for (Key key : more) {
            key.section = section;
            keys.push_back(key);
        }
    };
    add("", {
        {.name = "name", .type = kText, .required = true,
         .means = "names `build/<name>`, which one scene has: a letter, then at most 63 letters, digits, `_` and `-`"},
    });
    add("mesh", {
        {.name = "element", .type = kWord, .words = words_of<Element>(),
         .fallback = "linear",
         .means = "how a tetrahedron deforms; the last two do not lock "
                  "near Poisson's ratio 0.5 ([design/elements.md](design/elements.md))"},
        {.name = "generate", .type = kWord, .words = {"cube"},
         .means = "5 tetrahedra a cell, neighbours mirrored, corner at the origin"},
        {.name = "nodes_per_side", .type = kInteger, .range = {2, kMostNodesPerSide}, .fallback = 5,
         .means = "of the cube"},
        {.name = "side", .unit = "m", .range = kPositive, .fallback = 0.03,
         .means = "of the cube"},
        {.name = "file", .type = kText,
         .means = "a mesh file, relative to the scene; or `generate`"},
        {.name = "scale", .unit = "m", .range = kPositive, .fallback = 1.0,
         .means = "metres per unit of the file"},
        {.name = "linearize", .type = kFlag, .fallback = false,
         .means = "take second-order tetrahedra by their corners; the middles of their edges are left out, or made "
          "straight for `\"quadratic\"`"},
        {.name = "edge_length", .unit = "m", .range = kPositive,
         .means = "fills a closed surface with tetrahedra of that mean edge"},
        {.name = "node_count", .type = kInteger, .range = {.least = kFewestNodes},
         .means = "the same, to that number of corners; creases are kept unless that misses it or the volume (a note "
          "says so)"},
        {.name = "wrap", .type = kFlag, .fallback_text = "where needed",
         .means = "`true`: a surface is wrapped, then filled; `false`: never"},
    });
    add_material(keys, "material");
    add("material", {
        {.name = "stiffening", .type = kByLaw, .changes = kTables,
         .means = "[how dents stiffen](MATERIALS.md#dents-that-stiffen), regions too: `{ yeoh = [y2, y3] }`, "
                  "`{ fung = b }`, a measured press, `{ curve = \"press.csv\", at = [x, y, z] }`, or haptable-fit's "
                  "`{ curve = [c1, c2, c3], energy = e0 }`"},
    });
    add_where(keys, "region");
    add_material(keys, "region");
    add("region", {
        {.name = "density", .unit = "kg/m^3", .range = kPositive, .fallback_text = "the body's",
         .means = "its density, for weight and motion"},
    });
    add_where(keys, "fixed");
    add("fixed", {
        {.name = "below", .unit = "m", .range = kNotNegative,
         .means = "or the height of a layer above the lowest node along the axis"},
        {.name = "axis", .type = kWord, .words = {"z", "x", "y", "-x", "-y", "-z"}, .fallback_text = "`\"z\"`",
         .means = "`\"-z\"`: below the highest"},
    });
    add_where(keys, "membrane");
    add("membrane", {
        {.name = "thickness", .unit = "m", .range = kPositive, .required = true,
         .means = "thickness of the skin"},
        {.name = "young", .unit = "Pa", .range = kModulus, .required = true,
         .means = "Young's modulus of the skin"},
        {.name = "poisson", .range = {.least = -1.0, .most = 0.5, .above = true}, .required = true,
         .means = "Poisson's ratio of the skin"},
    });
    add_where(keys, "bed");
    add("bed", {
        {.name = "normal", .unit = "N/m^3", .range = kNotNegative, .fallback = 0.0,
         .means = "stiffness normal to the surface; it or the tangential one is above 0"},
        {.name = "tangential", .unit = "N/m^3", .range = kNotNegative, .fallback = 0.0,
         .means = "stiffness along the surface"},
    });
    add("gravity", {
        {.name = "density", .unit = "kg/m^3", .range = kPositive, .required = true,
         .means = "density, but for regions that have their own"},
        {.name = "direction", .type = kDirection, .fallback = {0.0, 0.0, -1.0},
         .means = "direction of the weight"},
        {.name = "acceleration", .unit = "m/s^2", .range = kPositive, .fallback = 9.81,
         .means = "acceleration of the weight"},
        {.name = "prestress", .type = kFlag, .fallback = false,
         .means = "the stress of the weight is in the stiffness"},
    });
    add("relaxation", {
        {.name = "share", .range = kPositive, .required = true, .changes = kTables,
         .means = "share of the instant stiffness that is lost; all shares together below 1"},
        {.name = "time", .unit = "s", .range = kPositive, .required = true, .changes = kTables,
         .means = "relaxation time of that share"},
    });
    add_where(keys, "touch");
    add("touch", {
        {.name = "cavities", .type = kFlag, .fallback = false,
         .means = "patches of inner cavities too"},
    });
    add("body", {
        {.name = "free", .type = kFlag, .fallback = false, .changes = kTables,
         .means = "no `[[fixed]]` and no `[[bed]]` holds it"},
        {.name = "density", .unit = "kg/m^3", .range = kPositive, .fallback_text = "that of `[gravity]`",
         .changes = kTables,
         .means = "density, but for regions that have their own"},
        {.name = "mass", .unit = "kg", .range = {kLeastMass_kg, kMostMass_kg},
         .beyond = "is {:g} kg, and a servo moves 1e-06 to 1e+06 kg: give it in kg", .changes = kTables,
         .means = "mass of the body, to which all densities are scaled; `mass`, `density` or `[gravity]` is required"},
        {.name = "suspension", .type = kSix, .unit = "N/m, N m/rad", .range = kNotNegative, .changes = kTables,
         .means = "stiffness that holds the centre of mass, along x, y, z, then about them"},
        {.name = "suspension_damping", .type = kSix, .unit = "N s/m, N m s", .range = kNotNegative,
         .fallback_text = "zeros", .changes = kTables,
         .means = "damping of the suspension, the same six"},
        {.name = "floor", .unit = "m", .changes = kTables,
         .means = "height of a floor along its normal"},
        {.name = "floor_normal", .type = kDirection,
         .fallback_text = "against gravity, else z", .changes = kTables,
         .means = "normal of the floor, upwards"},
        {.name = "floor_friction", .range = kNotNegative,
         .fallback_of = [](const SceneOptions& above) { return above.has("body.floor") ? Json(0.5) : Json(); },
         .fallback_text = "0.5", .changes = kTables,
         .means = "Coulomb's coefficient"},
        {.name = "modes", .type = kInteger, .range = {0, kMostModes}, .fallback = 0,
         .beyond = "is {}, and a servo has 0 to 16", .changes = kTables,
         .means = "number of modes that [ring](MOVING.md#modes), the lowest ones"},
        {.name = "mode_damping", .range = {.least = kLeastModeDamping, .most = 1.0, .below = true},
         .fallback_of = mode_damping,
         .fallback_text = "0.05",
         .beyond = "is {}, the ratio to critical damping, and must be at least 0.0001 and below 1",
         .changes = kTables,
         .means = "damping ratio of each mode, to critical damping"},
    });
    add("tool", {
        {.name = "shape", .type = kWord, .words = {"points", "sphere", "capsule", "disc", "mesh"}, .fallback = "points",
         .means = "what is sampled, on the side along the tool's -z; `\"points\"`: none, the points are given"},
        {.name = "points", .type = kPoints, .range = {kFewestPoints, kMostPoints}, .required = true,
         .beyond = "are {}, and a tool has 2 to 32", .changes = kTables,
         .means = "number of points of a shape; or the points, `[[x, y, z], ...]`, in metres about the handle"},
        {.name = "radius", .unit = "m", .range = kPositive,
         .means = "radius of a sphere or capsule about the handle, or of a disc"},
        {.name = "length", .unit = "m", .range = kPositive,
         .means = "length of a capsule along x, between the centres of its ends"},
        {.name = "file", .type = kText,
         .means = "mesh file of a tool, relative to the scene; its origin is the handle"},
        {.name = "scale", .unit = "m", .range = kPositive, .fallback_text = "1",
         .means = "metres per unit of that file"},
        {.name = "angle", .unit = "degrees", .range = {.least = 0.0, .most = kMostAngle_deg, .above = true},
         .fallback_text = "60",
         .means = "largest angle between -z and the normals of what is sampled, of all but a disc"},
        {.name = "max_torque", .unit = "N m", .range = kPositive, .fallback_text = "`max_force` at the farthest point",
         .changes = kTables,
         .means = "largest torque of the motors"},
        {.name = "stiffness", .unit = "N/m", .range = kPositive, .fallback_text = "none", .changes = kTables,
         .means = "stiffness of a virtual coupling between hand and tool"},
        {.name = "turn_stiffness", .unit = "N m/rad", .range = kPositive, .fallback_text = "none", .changes = kTables,
         .means = "its stiffness about the handle"},
    });
    add("contact", {
        {.name = "force", .type = kWord, .words = words_of<ForceLaw>(),
         .fallback = "interpolated", .changes = kTables,
         .means = "[how a point's force follows](CONTACT.md)"},
        {.name = "mask_radius", .unit = "m", .range = kPositive, .fallback_text = "required with `\"pressure-mask\"`",
         .changes = kTables,
         .means = "radius of the pressure mask"},
        {.name = "god_object", .type = kWord, .words = words_of<GodObject>(),
         .fallback_of = [](const SceneOptions& above) { return Json(is_free(above) ? "least-energy" : "nearest"); },
         .fallback_text = "`\"nearest\"`; free: `\"least-energy\"`", .changes = kTables,
         .means = "which point of the surface stands for the finger"},
        {.name = "rigid_stiffness", .unit = "N/m", .range = kPositive, .fallback = 1000.0, .changes = kTables,
         .means = "stiffness of a fixed node of a touchable patch"},
        {.name = "friction", .range = kNotNegative, .fallback = 0.0, .changes = kTables,
         .means = "Coulomb's coefficient of static friction"},
        {.name = "kinetic_friction", .range = kPositive,
         .fallback_of = [](const SceneOptions& above) { return above.at("contact.friction"); },
         .fallback_text = "as `friction`", .changes = kTables,
         .means = "the kinetic coefficient, at most `friction`"},
        {.name = "fingers", .type = kInteger, .range = {1, 8}, .fallback = 1, .beyond = "is {} and must be 1 to 8",
         .changes = kTables,
         .means = "number of [fingers](MOVING.md#two-fingers) on the body at once"},
        {.name = "release_slew", .unit = "N/ms", .range = kNotNegative, .fallback_of = release_slew,
         .fallback_text = "0; 0.01 with `\"least-energy\"` of one finger or two, if held", .changes = kTables,
         .means = "rate at which a force that has ended falls; 0: at once"},
        {.name = "coupling", .unit = "N/m", .range = kPositive, .words = {"none", "auto"}, .fallback = "none",
         .changes = kTables,
         .means = "stiffness of a virtual coupling in series with every point; `\"auto\"`: as the device needs"},
        {.name = "passivity", .type = kFlag, .fallback = false, .changes = kTables,
         .means = "a passivity controller damps until energy that was given is paid back"},
        {.name = "grab", .type = kFlag, .fallback = false, .changes = kTables,
         .means = "button 1 holds the contact point, and the body pulls too"},
    });
    add("device", {
        {.name = "model", .type = kWord, .words = model_names(), .fallback = "phantom",
         .means = "whose figures stand where no key gives one ([DEVICES.md](DEVICES.md#models))"},
        {.name = "max_force", .unit = "N", .range = kPositive, .fallback_of = of_model<&DeviceModel::max_force_n>,
         .fallback_text = "the model's", .changes = kTables,
         .means = "largest force of the motors"},
        {.name = "mass", .type = kOneOrThree, .unit = "kg", .range = kPositive, .fallback_of = mass_of_model,
         .fallback_text = "the model's",
         .means = "apparent mass along the device's axes"},
        {.name = "damping", .unit = "N s/m", .range = kNotNegative,
         .fallback_of = of_model<&DeviceModel::damping_n_s_per_m>, .fallback_text = "the model's", .changes = kTables,
         .means = "viscous damping of the bearings"},
        {.name = "friction", .unit = "N", .range = kNotNegative, .fallback_of = of_model<&DeviceModel::friction_n>,
         .fallback_text = "the model's", .changes = kTables,
         .means = "Coulomb friction of the bearings"},
        {.name = "encoder_step", .unit = "m", .range = kNotNegative,
         .fallback_of = of_model<&DeviceModel::encoder_step_m>, .fallback_text = "the model's", .changes = kTables,
         .means = "resolution of the encoders"},
        {.name = "bandwidth", .unit = "Hz", .range = kNotNegative,
         .fallback_of = of_model<&DeviceModel::bandwidth_hz>, .fallback_text = "the model's", .changes = kTables,
         .means = "bandwidth of the motors; 0: without lag"},
        {.name = "delay", .unit = "s", .range = {0.0, kMostDelay_s}, .fallback_of = of_model<&DeviceModel::delay_s>,
         .fallback_text = "the model's", .beyond = "is {} s, and a servo takes what is 0.02 s old for silence",
         .changes = kTables,
         .means = "delay of a force on its way to the motors"},
        {.name = "max_speed", .unit = "m/s", .range = kPositive, .words = {"off"}, .fallback = kMaxSpeed,
         .changes = kTables,
         .means = "a position that no finger of this speed reaches is not believed"},
        {.name = "max_force_rate", .unit = "N/s", .range = kPositive, .words = {"off"},
         .fallback_of = max_force_rate,
         .fallback_text = "100 `max_force`", .changes = kTables,
         .means = "largest rate at which the force rises"},
        {.name = "mean_force", .unit = "N", .range = kPositive, .words = {"off"},
         .fallback_of = of_model<&DeviceModel::continuous_force_n>, .fallback_text = "the model's continuous force",
         .changes = kTables,
         .means = "largest root mean squared force, which heats the motors"},
        {.name = "mean_force_time", .unit = "s", .range = kPositive, .fallback = 30.0, .changes = kTables,
         .means = "time over which that mean is taken"},
        {.name = "force_return", .type = kWord, .words = {"leaving", "ramp"}, .fallback = "leaving",
         .changes = kTables,
         .means = "how a force comes back inside the body: after the finger has left, or by a ramp "
          "([SAFETY.md](SAFETY.md#what-a-servo-does))"},
        {.name = "ramp_time", .unit = "s", .range = kPositive,
         .fallback_of = ramp_time,
         .fallback_text = "1.0", .changes = kTables,
         .means = "duration of that ramp"},
        {.name = "position", .type = kThree, .unit = "m", .fallback = {0.0, 0.0, 0.0},
         .means = "the device's origin [at the body](DEVICES.md#from-the-devices-hand-to-the-body)"},
        {.name = "rotation", .type = kThree, .unit = "degrees", .fallback = {0.0, 0.0, 0.0},
         .means = "rotation of the device about the body's x, then y, then z"},
        {.name = "handedness", .type = kWord, .words = {"right", "left"}, .fallback = "right",
         .means = "handedness of the device's coordinates"},
        {.name = "motion_scale", .range = kPositive, .fallback = 1.0, .changes = kTables,
         .means = "motion at the body over motion of the hand"},
        {.name = "force_scale", .range = kPositive, .fallback = 1.0, .changes = kTables,
         .means = "force on the hand over force at the body"},
        {.name = "clutch_ramp", .unit = "s", .range = kNotNegative, .fallback = 0.1,
         .means = "time in which the force falls and comes back"},
        {.name = "workspace", .type = kBox, .unit = "m", .fallback_text = "endless",
         .means = "box in the device's coordinates, outside of which the force falls"},
    });
    add("tables", {
        {.name = "precision", .type = kWord, .words = words_of<Storage>(), .fallback = "float32",
         .changes = kTables,
         .means = "how the servo stores the blocks that the force reads, where flash is short"},
        {.name = "columns", .type = kWord, .words = words_of<ColumnRows>(), .fallback = "surface",
         .changes = kTables,
         .means = "nodes whose displacement is kept to draw the deformation"},
        {.name = "column_precision", .type = kWord, .words = {"float32", "float16"}, .fallback = "float32",
         .changes = kTables,
         .means = "`\"float16\"` halves the columns' file"},
        {.name = "column_budget", .unit = "bytes", .range = kNotNegative, .fallback = 4e9,
         .means = "budget of columns.npy; larger columns are not written, and the viewer solves for each frame"},
        {.name = "flash_budget", .type = kInteger, .unit = "bytes", .range = kPositive, .fallback_text = "none",
         .means = "budget of the servo's tables; over it, an error lists what takes the room and what would fit"},
        {.name = "check", .type = kFlag, .fallback = true, .changes = kTables,
         .means = "the servo looks whether its tables' CRC is right"},
        {.name = "coupling_bytes", .type = kInteger, .unit = "bytes", .range = kPositive, .fallback = 2'000'000,
         .changes = kTables,
         .means = "budget of the tables that couple fingers"},
        {.name = "display_rows", .type = kNodes, .fallback_text = "none", .changes = kTables,
         .means = "mesh nodes, at most 1,000, whose displacement the microcontroller computes"},
        {.name = "display_precision", .type = kWord, .words = {"float32", "int16"}, .fallback = "float32",
         .changes = kTables,
         .means = "how the microcontroller stores the columns of `display_rows`"},
    });
    return keys;
}

std::vector<Rule> make_rules() {
    using enum Rule::Kind;
    constexpr const char* kFilled = "belongs to a surface file that is filled; give the cube nodes_per_side";
    constexpr const char* kGenerated = "belongs to generate = \"cube\"; remove it or the file";
    constexpr const char* kEither = "give either a box or a group";
    constexpr const char* kHeld = "is of a body that is not held; add free = true";
    constexpr const char* kMoves = "is of a body that moves; add free = true or modes";
    constexpr const char* kOfColumns = "is of the columns, and columns = \"none\" leaves them out; remove one of them";
    return {
        {kExcludes, "mesh.file", "mesh.generate", "there is a generator too; keep either generate or file"},
        {kNeeds, "mesh", "mesh.generate|mesh.file", "is missing; give a mesh file, or generate = \"cube\"",
         "mesh.file"},
        {kExcludes, "mesh.linearize", "mesh.generate", "belongs to a mesh file; the cube is linear: remove it"},
        {kExcludes, "mesh.edge_length", "mesh.generate", kFilled},
        {kExcludes, "mesh.node_count", "mesh.generate", kFilled},
        {kExcludes, "mesh.wrap", "mesh.generate", kFilled},
        {kExcludes, "mesh.scale", "mesh.generate",
         "belongs to a mesh file; give the cube's side in metres and remove it"},
        {kExcludes, "mesh.nodes_per_side", "mesh.file", kGenerated},
        {kExcludes, "mesh.side", "mesh.file", kGenerated},
        {kExcludes, "mesh.node_count", "mesh.edge_length", "there is an edge_length too; keep one of them"},
        {kNeeds, "mesh.wrap=true", "mesh.node_count|mesh.edge_length",
         "belongs to a surface that is filled; give node_count or edge_length, or remove it"},
        {kExcludes, "fixed.box", "fixed.below", "there is below too; keep one of them"},
        {kExcludes, "fixed.group", "fixed.below", "there is below too; keep one of them"},
        {kNeeds, "fixed.axis", "fixed.below", "belongs to below, metres; give it"},
        {kNeeds, "fixed", "fixed.below|fixed.box|fixed.group", "give a box, a group or below", "fixed.below"},
        {kExcludes, "fixed.box", "fixed.group", kEither},
        {kOneOf, "region", "region.box|region.group", kEither, "region.box"},
        {kOneOf, "membrane", "membrane.box|membrane.group", kEither, "membrane.box"},
        {kOneOf, "bed", "bed.box|bed.group", kEither, "bed.box"},
        {kOneOf, "touch", "touch.box|touch.group", kEither, "touch.box"},
        {kNeeds, "region.density", "gravity|body.free=true|body.modes>0",
         "belongs to a scene with [gravity]; add that table"},
        {kNeeds, "bed", "bed.normal>0|bed.tangential>0",
         "give normal or tangential, in N/m^3, greater than 0", "bed.normal"},
        {kNeeds, "body.suspension", "body.free=true", kHeld},
        {kNeeds, "body.suspension_damping", "body.free=true", kHeld},
        {kNeeds, "body.floor", "body.free=true", kHeld},
        {kNeeds, "body.floor_normal", "body.free=true", kHeld},
        {kNeeds, "body.floor_friction", "body.free=true", kHeld},
        {kNeeds, "body.density", "body.free=true|body.modes>0", kMoves},
        {kNeeds, "body.mass", "body.free=true|body.modes>0", kMoves},
        {kNeeds, "body.mode_damping", "body.modes>0", "needs modes, how many ring; give it"},
        {kExcludes, "body.free=true", "fixed", "is true, and [[fixed]] holds the body; remove one of them"},
        {kExcludes, "body.free=true", "bed", "is true, and [[bed]] holds the body; remove one of them"},
        {kExcludes, "body.free=true", "gravity.prestress=true",
         "is true, and prestress needs a body that is held under its weight; remove that"},
        {kExcludes, "body.density", "gravity", "is in [gravity] already; remove one of them"},
        {kNeeds, "body.free=true", "gravity|body.density|body.mass",
         "is missing: a body that is not held needs a density or a mass, or [gravity]", "body.density"},
        {kNeeds, "body.suspension_damping", "body.suspension", "needs suspension, six stiffnesses; give them"},
        {kNeeds, "body.floor_normal", "body.floor", "needs floor, its height; give it"},
        {kNeeds, "body.floor_friction", "body.floor", "needs floor, its height; give it"},
        {kExcludes, "body.modes>0", "gravity.prestress=true",
         "are those of the body without stress; remove prestress, or modes"},
        {kExcludes, "body.modes>0", "relaxation", "are of an elastic body: remove [[relaxation]], or modes"},
        {kExcludes, "material.stiffening", "body.modes>0",
         "is of the whole dent, of which modes take a part that stays linear: remove it, or modes"},
        {kExcludes, "material.stiffening", "contact.fingers>2",
         "is of the dents of one finger or two: remove it, or the other fingers"},
        {kExcludes, "material.stiffening", "tool", "is of the dent of one finger: remove it, or [tool]"},
        {kExcludes, "material.stiffening", "contact.coupling=auto",
         "is of the body alone, and a coupling is in series with it: remove one of them"},
        {kExcludes, "material.stiffening", "contact.coupling>0",
         "is of the body alone, and a coupling is in series with it: remove one of them"},
        {kExcludes, "material.stiffening", "gravity.prestress=true",
         "begins at a body without stress: remove it, or prestress"},
        {kExcludes, "material.stiffening", "bed", "is of a body that nodes hold: remove it, or [[bed]]"},
        {kExcludes, "material.stiffening", "membrane", "is of a body without a skin: remove it, or [[membrane]]"},
        {kExcludes, "body.modes>0", "contact.passivity=true",
         "count what contacts give themselves: remove passivity, or modes"},
        {kNeeds, "body.modes>0", "gravity|body.density|body.mass",
         "is missing: a body that rings needs a density or a mass, or [gravity]", "body.density"},
        {kNeeds, "contact.force=pressure-mask", "contact.mask_radius",
         "is missing; give a number", "contact.mask_radius"},
        {kNeeds, "contact.mask_radius", "contact.force=pressure-mask",
         "belongs to force = \"pressure-mask\"; remove it or choose that force"},
        {kNeeds, "contact.kinetic_friction", "contact.friction>0",
         "needs friction, the static coefficient; give it or remove this line"},
        {kExcludes, "contact.release_slew>0", "body.free=true",
         "keeps a force up that has ended, and a body that is free would be thrown by it; remove it"},
        {kExcludes, "contact.passivity=true", "body.free=true",
         "is what the motion of a body that is free does already; remove it"},
        {kNeeds, "device.mean_force_time", "device.mean_force>0",
         "is of mean_force, which is off; remove one of them"},
        {kNeeds, "device.ramp_time", "device.force_return=ramp",
         "belongs to force_return = \"ramp\"; remove it or choose that"},
        {kNeeds, "tables.coupling_bytes", "contact.fingers>1|tool",
         "belongs to several fingers or a tool; write fingers = 2 in [contact], or remove it"},
        {kNeeds, "contact.fingers>2", "contact.force=consistent|contact.force=pressure-mask",
         "are coupled by the body: set force = \"pressure-mask\" or \"consistent\" in [contact]", "contact.fingers"},
        {kExcludes, "contact.fingers>2", "body.free=true",
         "press a body that is held: remove free = true in [body], or let two press it", "contact.fingers"},
        {kExcludes, "contact.fingers>2", "body.modes>0",
         "press a body that follows at once: remove modes in [body], or let two press it", "contact.fingers"},
        {kExcludes, "contact.fingers>2", "relaxation",
         "have no part for a body that relaxes: remove [[relaxation]], or let two press it", "contact.fingers"},
        {kExcludes, "contact.fingers>2", "contact.release_slew>0",
         "end with their contacts: remove release_slew in [contact]", "contact.fingers"},
        {kExcludes, "contact.fingers>2", "contact.grab=true",
         "push and do not hold: remove grab in [contact], or let two press it", "contact.fingers"},
        {kNeeds, "tool", "contact.force=consistent|contact.force=pressure-mask",
         "are coupled by the body: set force = \"pressure-mask\" or \"consistent\" in [contact]", "tool.points"},
        {kExcludes, "tool", "contact.fingers>1", "are of one hand: remove fingers in [contact]", "tool.points"},
        {kExcludes, "tool", "body.free=true", "are pressed into a body that is held: remove free = true in [body]",
         "tool.points"},
        {kExcludes, "tool", "body.modes>0", "are pressed into a body that follows at once: remove modes in [body]",
         "tool.points"},
        {kExcludes, "tool", "relaxation", "have no part for a body that relaxes: remove [[relaxation]]", "tool.points"},
        {kExcludes, "tool", "contact.release_slew>0", "end with their contact: remove release_slew in [contact]",
         "tool.points"},
        {kExcludes, "tool", "contact.grab=true", "push and do not hold: remove grab in [contact]", "tool.points"},
        {kNeeds, "tool.shape=sphere", "tool.radius", "is missing; give a number, m", "tool.radius"},
        {kNeeds, "tool.shape=capsule", "tool.radius", "is missing; give a number, m", "tool.radius"},
        {kNeeds, "tool.shape=disc", "tool.radius", "is missing; give a number, m", "tool.radius"},
        {kNeeds, "tool.shape=capsule", "tool.length", "is missing; give a number, m", "tool.length"},
        {kNeeds, "tool.shape=mesh", "tool.file", "is missing; name a mesh file", "tool.file"},
        {kNeeds, "tool.radius", "tool.shape=sphere|tool.shape=capsule|tool.shape=disc",
         "belongs to a sphere, a capsule or a disc; remove it or choose that shape"},
        {kNeeds, "tool.length", "tool.shape=capsule", "belongs to a capsule; remove it or choose that shape"},
        {kNeeds, "tool.file", "tool.shape=mesh", "belongs to shape = \"mesh\"; remove it or choose that shape"},
        {kNeeds, "tool.scale", "tool.shape=mesh", "belongs to shape = \"mesh\"; remove it or choose that shape"},
        {kNeeds, "tool.angle", "tool.shape=sphere|tool.shape=capsule|tool.shape=mesh",
         "belongs to a sphere, a capsule or a mesh; remove it or choose that shape"},
        {kNeeds, "tool.turn_stiffness", "tool.stiffness", "needs stiffness, N/m, of the same coupling; give it"},
        {kNeeds, "tool.stiffness", "tool.turn_stiffness",
         "needs turn_stiffness, N m/rad, of the same coupling; give it"},
        {kNeeds, "tables.display_precision", "tables.display_rows",
         "is of display_rows, which the microcontroller computes; give them, or remove it"},
        {kExcludes, "tables.display_rows", "tables.columns=none",
         "needs columns, and columns = \"none\" leaves them out"},
        {kExcludes, "tables.column_precision", "tables.columns=none", kOfColumns},
        {kExcludes, "tables.column_budget", "tables.columns=none", kOfColumns},
        {kExcludes, "tables.display_rows", "tables.column_precision=float16",
         "needs columns in float32: remove column_precision"},
        {kExcludes, "tables.display_rows", "contact.force=pressure-mask",
         "a pressure mask spreads its load over nodes that only the host knows"},
                          };
}

// clang-format on

}  // namespace

const std::vector<SectionKey>& scene_sections() {
    static const std::vector<SectionKey> sections{
        {.name = "", .means = "the scene itself"},
        {.name = "mesh", .required = true, .means = "a generator, or a file; and how its tetrahedra deform"},
        {.name = "material", .required = true, .means = "what the body is made of, but for regions"},
        {.name = "region",
         .is_list = true,
         .means = "another material, for the tetrahedra of a group, or with their centre in a box"},
        {.name = "fixed",
         .is_list = true,
         .means = "nodes held still; required, where no `[[bed]]` holds the body and it is not free"},
        {.name = "membrane",
         .is_list = true,
         .means = "[skin](MATERIALS.md) on the surface's faces of a group, or with all their nodes in a box"},
        {.name = "bed", .is_list = true, .means = "[springs to the ground](MATERIALS.md) under such faces"},
        {.name = "gravity", .is_optional = true, .means = "[weight](MATERIALS.md)"},
        {.name = "relaxation", .is_list = true, .means = "[how it gives way](MATERIALS.md#time), at most eight terms"},
        {.name = "touch",
         .is_list = true,
         .means = "patches that the finger may meet; left out: the whole outer surface"},
        {.name = "body",
         .is_optional = true,
         .means = "[nothing holds it](MOVING.md#free-bodies), or it [rings](MOVING.md#modes)"},
        {.name = "tool",
         .is_optional = true,
         .means = "[a rigid tool](TOOL.md) that one hand holds, in place of a finger"},
        {.name = "contact", .means = "[how a touch feels](CONTACT.md)"},
        {.name = "device", .means = "[whose motors give the force](DEVICES.md)"},
        {.name = "tables", .means = "what is stored"},
    };
    return sections;
}

const std::vector<Key>& scene_keys() {
    static const std::vector<Key> keys = make_keys();
    return keys;
}

const std::vector<Rule>& scene_rules() {
    static const std::vector<Rule> rules = make_rules();
    return rules;
}

std::vector<const Key*> keys_of(std::string_view section) {
    std::vector<const Key*> keys;
    for (const Key& key : scene_keys())
        if (section == key.section) keys.push_back(&key);
    return keys;
}

Json fallback_of(const Key& key, const SceneOptions& above) {
    return key.fallback_of != nullptr ? key.fallback_of(above) : key.fallback;
}

std::string text_of_tables(const SceneOptions& options) {
    SceneOptions changing;
    for (const Key& key : scene_keys()) {
        if (key.changes == Changes::kNothing) continue;
        const std::string name = std::string(key.section) + "." + key.name;
        const auto section = options.values().find(key.section);
        if (section != options.values().end() && section->is_array())
            changing.set(key.section, *section);
        else if (options.has(name))
            changing.set(name, options.at(name));
    }
    return json_text(changing.values());
}

}  // namespace haptable
