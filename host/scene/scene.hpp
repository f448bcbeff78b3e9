// SPDX-License-Identifier: GPL-2.0-or-later
// The scene file (TOML): a mesh, a material, what is held still, where it may be touched, and by which device.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/base/modes.hpp"
#include "host/base/relaxation.hpp"
#include "host/base/scene_options.hpp"
#include "host/scene/device.hpp"
#include "host/scene/material.hpp"
#include "host/scene/tool.hpp"

namespace haptable {

/// [mesh]: either the cube generator or a file; and how its tetrahedra deform.
struct MeshSource {
    Element element = Element::kLinear;
    std::string generate;                 ///< "cube", or empty where a file is named
    int nodes_per_side = 5;               ///< of the generated cube, 2 or more
    double side_m = 0.03;                 ///< of the generated cube
    std::filesystem::path file;           ///< as it can be opened: already relative to the scene's folder
    double scale_m = 1.0;                 ///< metres per unit of the file
    bool linearize = false;               ///< take second-order tetrahedra by their corners
    double edge_length_m = 0.0;           ///< mean edge that a closed surface is filled with; 0: not given
    std::size_t node_count = 0;           ///< nodes that a closed surface is filled with; 0: not given
    std::optional<bool> wrap;             ///< a surface before it is filled; none: where nothing else fills it
    std::vector<std::string> directions;  ///< cell vectors of the file that materials are turned by
};

/// A layer of the body, measured from its outermost node along an axis.
struct Below {
    double depth_m = 0.0;
    int axis = 2;            ///< 0 x, 1 y, 2 z
    bool is_turned = false;  ///< from the highest node downwards: the axis is -x, -y or -z
};

/// One [[fixed]], [[touch]] or [[region]] table: a box, or a named group of the mesh file.
struct Selection {
    std::optional<std::array<double, 6>> box_m;  ///< xmin ymin zmin xmax ymax zmax, borders included
    std::string group;                           ///< empty where a box or a layer is given
    int line = 0;                                ///< of the table in the scene file, for errors
    bool cavities = false;                       ///< [[touch]] only: inner cavities too
    std::optional<Below> below{};                ///< [[fixed]] only: instead of box and group
};

/// [[region]]: other tetrahedra than the body's, those of a group or with their centre in a box.
struct Region {
    Selection where;
    Material material;
    std::optional<double> density_kg_per_m3 = {};  ///< as [gravity] or [body] where it is not given
};

/// [[membrane]]: faces of the surface that a skin covers, in plane stress; it does not bend.
struct Membrane {
    Selection where;
    double thickness_m = 0.0;
    double young_pa = 0.0;
    double poisson = 0.0;  ///< -1 < poisson <= 0.5
};

/// [[bed]]: faces of the surface that rest on springs to the ground (Winkler's), N/m for each m^2.
struct Bed {
    Selection where;
    double normal_n_per_m3 = 0.0;
    double tangential_n_per_m3 = 0.0;
};

/// [gravity]: what the body's own weight does.
struct Gravity {
    double density_kg_per_m3 = 0.0;  ///< of what no region holds
    std::array<double, 3> acceleration_m_per_s2{};
    bool prestress = false;  ///< the stress of the weight stiffens or softens the body
};

/// [body]: one that nothing holds; it moves as a rigid body too.
struct FreeBody {
    struct Floor {
        double height_m = 0.0;                        ///< along the normal
        std::array<double, 3> normal{0.0, 0.0, 1.0};  ///< up, length 1
        double friction = 0.0;                        ///< Coulomb's coefficient
    };
    double density_kg_per_m3 = 0.0;     ///< of what no region holds; 0: [gravity] says, or mass alone counts
    double mass_kg = 0.0;               ///< to which all densities are scaled; 0: as they are
    std::array<double, 6> stiffness{};  ///< of its suspension: N/m along x, y, z, N m/rad about them; 0: none
    std::array<double, 6> damping{};    ///< N s/m, N m s
    std::optional<Floor> floor;
    int line = 0;  ///< of [body] in the scene file, for errors
};

/// [body] modes: what of the elastic part rings, of a body that is held or not.
struct BodyModes {
    int modes = 0;                   ///< the lowest: 1 or more
    double damping_ratio = 0.0;      ///< of each, to critical damping: above 0, below 1
    double density_kg_per_m3 = 0.0;  ///< as FreeBody's, of a body that is held
    double mass_kg = 0.0;            ///< the same
    int line = 0;                    ///< of the key in the scene file, for errors
};

/// [contact]
struct ContactOptions {
    ForceLaw force = ForceLaw::kInterpolated;
    GodObject god_object = GodObject::kNearest;
    double mask_radius_m = 0.0;  ///< of a pressure mask; 0 for the other forces
    double rigid_stiffness_n_per_m = 1000.0;
    double static_friction = 0.0;   ///< Coulomb's; 0: none
    double kinetic_friction = 0.0;  ///< at most static_friction
    double release_n_per_ms = 0.0;  ///< how fast a force that ends is brought down; 0: at once
    bool passivity = false;         ///< a passivity observer and controller
    bool grab = false;              ///< a button holds the contact
    int fingers = 1;                ///< on the body at once: 1 to 8
    bool auto_coupling = false;     ///< the smallest virtual coupling that the device needs
    double coupling_n_per_m = 0.0;  ///< a virtual coupling in series; 0: none
};

/// [tables]
struct TableOptions {
    ColumnRows columns = ColumnRows::kSurface;
    Storage column_precision = Storage::kFloat32;  ///< float32 | float16
    double column_budget_bytes = 4e9;              ///< larger columns are not written: the viewer solves for each frame
    Storage precision = Storage::kFloat32;         ///< of S in the servo
    std::uintmax_t flash_budget = 0;               ///< most bytes of the servo's tables; 0: no bound
    std::uintmax_t coupling_bytes = 2'000'000;     ///< most of what couples two fingers in the servo's tables
    std::vector<std::int32_t> display_rows;  ///< mesh nodes whose displacement the target computes; none: no such table
    Storage display_precision = Storage::kFloat32;  ///< float32 | int16: of their columns in the firmware
};

struct Scene {
    std::filesystem::path file;
    std::string name;  ///< a letter, then letters, digits, '_' and '-': names build/<name> and the C model
    MeshSource mesh;
    Material material;  ///< of what no region holds
    std::vector<Region> regions;
    std::vector<Selection> fixed;
    std::vector<Membrane> membranes;  ///< they add where they share a face, and so do beds
    std::vector<Bed> beds;
    std::optional<Gravity> gravity;
    std::vector<RelaxationTerm> relaxation;  ///< none: an elastic body
    std::vector<Selection> touch;            ///< empty: the whole surface but inner cavities
    ContactOptions contact;
    Device device;
    DeviceMap device_map;
    TableOptions tables;
    std::optional<FreeBody> free_body;    ///< none: [[fixed]] or a bed holds it
    std::optional<BodyModes> body_modes;  ///< none: it follows at once
    std::optional<Tool> tool;             ///< none: a finger, or two
    SceneOptions options;                 ///< as the file has them; what stands above may have been changed since

    /// The material of a region, or of the body (-1).
    const Material& material_of(std::int32_t region) const {
        return region < 0 ? material : regions[static_cast<std::size_t>(region)].material;
    }
    /// The mass of [body], to which all densities are scaled; 0: they are as they are.
    double mass_kg() const { return free_body ? free_body->mass_kg : body_modes ? body_modes->mass_kg : 0.0; }
    /// With [gravity] or [body]; without a density there, 1.
    double density_of(std::int32_t region) const {
        const double given = free_body    ? free_body->density_kg_per_m3
                             : body_modes ? body_modes->density_kg_per_m3
                                          : 0.0;
        const double body = gravity ? gravity->density_kg_per_m3 : given > 0.0 ? given : 1.0;
        return region < 0 ? body : regions[static_cast<std::size_t>(region)].density_kg_per_m3.value_or(body);
    }
};

/// Every key with its value: options.json. Members of the scene before what the file says of them.
SceneOptions options_of(const Scene& scene);

/// Where the servo cuts a force of the body's, so that the motors meet their limit and no more.
double servo_force_limit_n(const Scene& scene);

/// The device's limits, which are of the hand's motion and force, as the servo meets them at the body.
SafetyLimits servo_limits(const Scene& scene);

/// Delay of a force until the motors give it: on its way, and behind their lag.
double whole_delay_s(const Device& device);

/// Reads and checks a scene. Throws Error "FILE:LINE: key: what is wrong" for a missing file, an unknown key, a wrong
/// type or an impossible value. The mesh file itself is not opened.
Scene read_scene(const std::filesystem::path& file);

}  // namespace haptable
