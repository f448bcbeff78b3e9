// SPDX-License-Identifier: GPL-2.0-or-later
// From a moment of a session to its finished picture: deformation, surface, rendering, annotation.
#pragma once

#include <filesystem>
#include <optional>

#include "host/tables/checks.hpp"
#include "host/tables/tables.hpp"
#include "host/view/annotate.hpp"
#include "host/view/deformation.hpp"
#include "host/view/drawn_modes.hpp"
#include "host/view/frame.hpp"
#include "host/view/renderer.hpp"
#include "host/view/sag.hpp"
#include "host/view/stress.hpp"
#include "host/view/surface.hpp"

namespace haptable {

/// What a picture's colours and arrow are measured by. Both only grow.
struct Ranges {
    double displacement_m = 0.0;
    double force_n = 0.0;
    double nodal_force_n = 0.0;
    double stress_pa = 0.0;
    std::size_t fingers = 1;
};

class Painter {
public:
    /// `folder`: of the tables. Without `deform` only the rest shape can be painted, and no columns are needed.
    Painter(const Tables& tables, const TablesFolder& folder, const ViewOptions& view, bool deform);
    /// The body under its own weight, whatever the frame; no columns are needed.
    Painter(const Sag& sag, const TablesFolder& folder, const ViewOptions& view);

    /// Deforms the surface as the frame's loads do and widens the ranges by it.
    void measure(const ContactFrame& frame, Ranges& ranges);
    /// Deforms and paints. Colours end at the range of what they show, the longest arrow stands for `ranges.force_n`.
    const Image& paint(const ContactFrame& frame, const Ranges& ranges);
    /// The rest shape alone (the paper's Figure 1 a).
    const Image& paint_mesh();
    /// The same as vectors, to an .svg or .pdf file.
    void figure(const ContactFrame& frame, const Ranges& ranges, const std::filesystem::path& path);
    void figure_mesh(const std::filesystem::path& path);

    const DrawnSurface& surface() const { return surface_; }
    const Renderer& renderer() const { return renderer_; }
    /// The markers of a frame, as they are painted.
    Markers markers(const ContactFrame& frame, const Ranges& ranges) const;

private:
    /// All that a picture is made of, but for the surface.
    struct Scene {
        Markers markers;
        Shading shading;
        Annotation notes;
    };

    std::span<const float> displace(const ContactFrame& frame);
    void deform(const ContactFrame& frame);
    void find_values(const ContactFrame& frame);
    ColorBar bar_of(const Ranges& ranges) const;
    Scene compose(const ContactFrame& frame, const Ranges& ranges);
    Scene compose_mesh();
    void add_place(Annotation& notes) const;
    void add_caption(const ContactFrame& frame, const Ranges& ranges, Annotation& notes) const;
    void add_weight(Annotation& notes) const;
    void add_faults(Annotation& notes) const;
    float room_for(const Eigen::Vector3f& from_m, const Eigen::Vector3f& arrow_m) const;

    const Tables& tables_;
    ViewOptions view_;
    MeshCheck check_;                       ///< of a mesh alone
    std::optional<double> small_strain_m_;  ///< depth up to which the force is a rubber's too
    std::optional<Deformation> deformation_;
    std::optional<DrawnModes> modes_;
    const std::vector<float>* sag_m_ = nullptr;  ///< [r,3] instead
    DrawnSurface surface_;
    Renderer renderer_;
    Image image_;
    std::optional<SurfaceStress> stress_;
    std::vector<float> value_;  ///< [m] what the colours show
};

}  // namespace haptable
