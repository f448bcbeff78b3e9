// SPDX-License-Identifier: GPL-2.0-or-later
// The picture of a deformed surface with finger, god-object and force, without a display.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "host/view/antialias.hpp"
#include "host/view/camera.hpp"
#include "host/view/colormap.hpp"
#include "host/view/image.hpp"
#include "host/view/offscreen.hpp"
#include "host/view/surface.hpp"

namespace haptable {

/// What stands beside the surface in a picture. Positions in metres.
struct Markers {
    std::optional<Eigen::Vector3f> finger;
    std::optional<Eigen::Vector3f> god_object;
    std::optional<Eigen::Vector3f> arrow_tip;  ///< of the force, which starts at the god-object
    std::vector<Markers> others;               ///< of further fingers
    std::optional<Eigen::Matrix4f> tool;       ///< from its axes to the world's
    std::vector<Eigen::Vector3f> touching;     ///< god-objects of its points
};

/// What the surface's colours show.
struct Shading {
    std::span<const float> value;  ///< [m] at every node; empty: no colours of the map
    float range = 0.0F;            ///< where the map ends
};

/// Colour of a patch: 0 a colour of the map; else a plain one: 1 not touchable, 2 held, 3 touchable.
int plain_color(const DrawnSurface& surface, std::size_t patch, bool colored);
const Rgb8& plain_color(int number);

class Renderer {
public:
    /// Draws this surface's patches, seen around its rest shape.
    Renderer(const ViewOptions& view, const DrawnSurface& surface);

    const Camera& camera() const { return camera_; }
    /// The body's size, m, by which the markers are sized: the diagonal of a cube as large as the rest shape's box.
    float size_m() const { return size_m_; }

    /// Markers have this tool: corners of its triangles, three each.
    void set_tool(std::span<const std::array<float, 3>> corner_m);
    /// Draws the surface as it is deformed now, coloured by `shading`.
    void draw(const DrawnSurface& surface, const Markers& markers, const Shading& shading, Image& image);

private:
    void bake_background(const DrawnSurface& surface, const ViewOptions& view);
    void upload_ghost(const DrawnSurface& surface);
    void upload_surface(const DrawnSurface& surface, const Shading& shading);
    PixelBox bounds(const DrawnSurface& surface, const Markers& markers) const;
    void draw_surface(bool inside_too);
    void draw_ghost();
    void draw_markers(const Markers& markers, float opacity, std::size_t number = 0);
    void draw_tool(const Markers& markers, float opacity);
    void draw_solid(const Triangles& shape, const Eigen::Matrix4f& place, const Eigen::Vector3f& color, float opacity);

    Eigen::Matrix3f upright_;
    std::vector<Eigen::Vector3f> upright_m_;  ///< [m] the rest shape, z up
    Eigen::Vector3f low_m_;                   ///< of it
    Eigen::Vector3f high_m_;
    float size_m_;
    Camera camera_;
    float line_px_;
    Offscreen target_;
    GLuint surface_program_;
    GLuint solid_program_;
    GLuint map_ = 0;
    Triangles surface_;  // position 3, normal 3, look 2, wide 3
    Triangles sphere_;   // position 3, normal 3
    Triangles rod_;
    Triangles cone_;
    Triangles ghost_;
    Triangles tool_;
    std::vector<Eigen::Vector3f> tool_m_;  ///< its corners
    bool has_ghost_;
    bool smooths_;
    Image background_;            ///< with the ground
    std::vector<float> corners_;  ///< of all patches, as they are uploaded
    Smoothing smooth_;
};

/// Radius of the spheres of finger and god-object, as a share of the body's size.
inline constexpr float kSphereShare = 0.017F;

}  // namespace haptable
