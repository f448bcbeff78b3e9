// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/painter.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "host/base/command_line.hpp"
#include "host/base/si.hpp"
#include "host/tables/checks.hpp"
#include "host/tables/tool.hpp"
#include "host/view/colormap.hpp"
#include "host/view/figure.hpp"

namespace haptable {

namespace {

constexpr float kLongestArrow = 0.23F;  // of the body's size
// Ranges of a session in which nothing has moved: some scale has to stand there.
constexpr double kLeastRange_m = 1e-6;
constexpr double kRestRange_m = 1e-3;
constexpr double kLeastRange_n = 1e-12;
constexpr double kRestRange_n = 1e-3;
constexpr double kLeastRange_pa = 1e-6;
constexpr double kRestRange_pa = 1e3;

float size_of(const NodalForce& load) { return Eigen::Vector3f(load.force_n.data()).norm(); }

Eigen::Vector3f to_float(const Eigen::Vector3d& v) { return v.cast<float>(); }

}  // namespace

Painter::Painter(const Tables& tables, const TablesFolder& folder, const ViewOptions& view, bool deform)
    : tables_(tables),
      view_(view),
      small_strain_m_(read_small_strain_depth(folder)),
      surface_(tables),
      renderer_(view, surface_) {
    if (deform) {
        deformation_.emplace(tables, folder);
        modes_ = read_drawn_modes(tables, folder);
        if (const std::optional<ToolTables> tool = read_tool(folder)) renderer_.set_tool(tool->surface_corner_m);
        if (view.color == "stress") stress_.emplace(tables, folder, surface_);
    } else
        check_ = read_mesh_check(folder, tables.position.size());
}

Painter::Painter(const Sag& sag, const TablesFolder& folder, const ViewOptions& view)
    : Painter(sag.tables, folder, view, false) {
    if (view.color != "displacement")
        throw BadCommandLine("--color " + view.color + ": of a sag the colours show displacement");
    sag_m_ = &sag.displacement_m;
}

std::span<const float> Painter::displace(const ContactFrame& frame) {
    const std::span<const float> displacement_m = deformation_->displace(frame.loads);
    return modes_ ? modes_->add_to(displacement_m, frame) : displacement_m;
}

void Painter::deform(const ContactFrame& frame) { surface_.deform(sag_m_ != nullptr ? *sag_m_ : displace(frame)); }

void Painter::measure(const ContactFrame& frame, Ranges& ranges) {
    deform(frame);
    for (const Eigen::Vector3f& u : surface_.displacement_m)
        ranges.displacement_m = std::max(ranges.displacement_m, static_cast<double>(u.norm()));
    for (const NodalForce& load : frame.loads)
        ranges.nodal_force_n = std::max(ranges.nodal_force_n, static_cast<double>(size_of(load)));
    ranges.force_n = std::max(ranges.force_n, frame.force_n.norm());
    ranges.fingers = std::max(ranges.fingers, 1 + frame.others.size());
    if (!stress_) return;
    find_values(frame);
    for (const float stress : value_) ranges.stress_pa = std::max(ranges.stress_pa, static_cast<double>(stress));
}

/// The largest share of an arrow that ends inside the picture, below the title.
float Painter::room_for(const Eigen::Vector3f& from_m, const Eigen::Vector3f& arrow_m) const {
    const auto width = static_cast<float>(view_.width), height = static_cast<float>(view_.height);
    const float unit = reference_px(view_.width, view_.height), edge = 0.03F * unit;
    const Eigen::AlignedBox2f room(Eigen::Vector2f(edge, kTopMargin * unit),
                                   Eigen::Vector2f(width - edge, height - kBottomMargin * unit));
    const auto is_inside = [&](float share) {
        return room.contains(renderer_.camera().pixel(from_m + share * arrow_m));
    };
    if (is_inside(1.0F) || !is_inside(0.0F)) return 1.0F;
    float in = 0.0F, out = 1.0F;
    for (int step = 0; step < 12; ++step) {
        const float middle = 0.5F * (in + out);
        (is_inside(middle) ? in : out) = middle;
    }
    return in;
}

Markers Painter::markers(const ContactFrame& frame, const Ranges& ranges) const {
    Markers markers;
    for (const ContactFrame::Other& of : frame.others) {
        ContactFrame other;
        other.finger_known = true;
        other.contact = of.contact;
        other.finger_m = of.finger_m;
        other.god_object_m = of.god_object_m;
        other.force_n = of.force_n;
        other.pose = frame.pose;
        markers.others.push_back(this->markers(other, ranges));
    }
    const Eigen::Vector3f god_object = to_float(frame.pose ? *frame.pose * frame.god_object_m : frame.god_object_m);
    if (frame.tool) {
        markers.tool = frame.tool->pose.matrix().cast<float>();
        for (const Eigen::Vector3d& at : frame.tool->god_object_m)
            markers.touching.push_back(to_float(frame.pose ? *frame.pose * at : at));
    }
    const bool is_seen = frame.finger_known && !frame.tool;  // a handle is within its tool
    if (is_seen) markers.finger = to_float(frame.finger_m);
    if (!frame.contact) return markers;
    if (is_seen) markers.finger = god_object + static_cast<float>(view_.exaggeration) * (*markers.finger - god_object);
    markers.god_object = god_object;
    if (!(ranges.force_n > 0.0)) return markers;
    const Eigen::Vector3f arrow = kLongestArrow * renderer_.size_m() * to_float(frame.force_n / ranges.force_n);
    markers.arrow_tip = god_object + room_for(god_object, arrow) * arrow;
    return markers;
}

/// Axes, a bar of length, and the surface's parts in the legend.
void Painter::add_place(Annotation& notes) const {
    const auto any = [](const std::vector<std::uint8_t>& flags) {
        return std::find(flags.begin(), flags.end(), 1) != flags.end();
    };
    bool closed = false;  // a part that moves and must not be touched
    for (std::size_t p = 0; p < surface_.patches(); ++p) closed |= surface_.touchable[p] == 0 && surface_.held[p] == 0;
    if (any(surface_.held)) notes.legend.push_back({"held", kHeldColor, LegendEntry::Sign::area});
    if (closed) notes.legend.push_back({"not touchable", kNeutralColor, LegendEntry::Sign::area});
    const Camera& camera = renderer_.camera();
    notes.axes = camera.to_eye().topLeftCorner<3, 3>();
    Eigen::AlignedBox3f box;
    for (const Eigen::Vector3f& x : surface_.rest_m) box.extend(x);
    notes.px_per_m = static_cast<double>(camera.pixels_per_m(box.center()));
}

void Painter::add_caption(const ContactFrame& frame, const Ranges& ranges, Annotation& notes) const {
    const Eigen::Vector3d god_object_m = frame.pose ? *frame.pose * frame.god_object_m : frame.god_object_m;
    // A tool's handle is at no depth.
    const double depth_m = frame.contact && !frame.tool ? (frame.finger_m - god_object_m).norm() : 0.0;
    notes.title = tables_.name;
    notes.details = {
        fmt::format("t = {:.3f} s", frame.time_s), fmt::format("tick {}", frame.number),
        frame.tool ? fmt::format("{} points touch", frame.tool->god_object_m.size()) : "u = " + si(depth_m, "m"),
        "|F| = " + si(frame.force_n.norm(), "N")};
    constexpr double kSame = 0.02;  // of the speed: nobody sees it
    if (view_.speed > 0.0 && std::abs(view_.speed - 1.0) > kSame)
        notes.details.push_back(view_.speed < 1.0 ? fmt::format("{:.3g} times slower", 1.0 / view_.speed)
                                                  : fmt::format("{:.3g} times faster", view_.speed));
    if (view_.exaggeration != 1.0) notes.details.push_back(fmt::format("displacements x {:g}", view_.exaggeration));
    notes.legend = {{frame.tool ? "tool" : "finger", kFingerColor[0]}};
    if (ranges.fingers > 1)
        notes.legend.push_back({ranges.fingers == 2 ? "second finger" : "other fingers", kFingerColor[1]});
    notes.legend.push_back({"god-object", kGodObjectColor});
    notes.legend.push_back(
        {frame.tool ? "force on the hand" : "force on the finger", kArrowColor, LegendEntry::Sign::arrow});
    if (small_strain_m_ && depth_m > *small_strain_m_)
        notes.warning = tables_.stiffening.energy_j > 0.0
                            ? fmt::format("beyond {}: the force may be off by 10 % and more", si(*small_strain_m_, "m"))
                            : fmt::format("beyond small strain ({}): a rubber's force would be off by 10 % and more",
                                          si(*small_strain_m_, "m"));
}

void Painter::add_weight(Annotation& notes) const {
    float most_m = 0.0F;
    for (const Eigen::Vector3f& u : surface_.displacement_m) most_m = std::max(most_m, u.norm());
    notes.title = tables_.name;
    notes.details = {"under its own weight", "moves by up to " + si(static_cast<double>(most_m), "m")};
    if (view_.exaggeration != 1.0) notes.details.push_back(fmt::format("displacements x {:g}", view_.exaggeration));
}

/// What the colours show, at every drawn node, of the surface as it is deformed now.
void Painter::find_values(const ContactFrame& frame) {
    if (stress_) return stress_->find(displace(frame), value_);
    const bool by_force = view_.color == "force";
    value_.clear();
    for (const Eigen::Vector3f& u : surface_.displacement_m) value_.push_back(by_force ? 0.0F : u.norm());
    if (!by_force) return;
    for (const NodalForce& load : frame.loads) {
        const auto found = std::lower_bound(surface_.node_id.begin(), surface_.node_id.end(), load.node);
        if (found != surface_.node_id.end() && *found == load.node)
            value_[static_cast<std::size_t>(found - surface_.node_id.begin())] += size_of(load);
    }
}

/// Where nothing has happened some scale has to stand there.
ColorBar Painter::bar_of(const Ranges& ranges) const {
    const auto range = [](double widest, double least, double rest) { return widest > least ? widest : rest; };
    if (view_.color == "force")
        return {"force on a node (mN)", 1e3 * range(ranges.nodal_force_n, kLeastRange_n, kRestRange_n)};
    if (view_.color == "stress")
        return {"von Mises stress (kPa)", 1e-3 * range(ranges.stress_pa, kLeastRange_pa, kRestRange_pa)};
    return {"displacement (mm)", 1e3 * range(ranges.displacement_m, kLeastRange_m, kRestRange_m)};
}

/// Deforms the surface as it is drawn, and finds all that stands beside it.
Painter::Scene Painter::compose(const ContactFrame& frame, const Ranges& ranges) {
    deform(frame);
    Scene scene;
    scene.markers = markers(frame, ranges);
    find_values(frame);
    const ColorBar bar = bar_of(ranges);
    const double per_unit = view_.color == "stress" ? 1e3 : 1e-3;  // of the bar's kPa, mN or mm
    scene.shading = {value_, static_cast<float>(per_unit * bar.range)};
    Annotation& notes = scene.notes;
    sag_m_ != nullptr ? add_weight(notes) : add_caption(frame, ranges, notes);
    notes.bar = bar;
    if (view_.exaggeration != 1.0)
        for (Eigen::Vector3f& u : surface_.displacement_m) u *= static_cast<float>(view_.exaggeration);
    surface_.update_normals();
    if (frame.pose) surface_.move(*frame.pose);
    add_place(notes);
    if (scene.markers.arrow_tip && frame.force_n.norm() > 0.0) {
        notes.label = si(frame.force_n.norm(), "N");
        notes.label_px = renderer_.camera().pixel(*scene.markers.arrow_tip);
        notes.label_direction = *notes.label_px - renderer_.camera().pixel(*scene.markers.god_object);
    }
    return scene;
}

/// Worst elements and hinges, over the surface, so that they are seen inside too.
void Painter::add_faults(Annotation& notes) const {
    const auto pixel = [&](std::int32_t node) {
        const auto& x = tables_.position[static_cast<std::size_t>(node)];
        return renderer_.camera().pixel(
            Eigen::Vector3f(static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2])));
    };
    for (const MeshCheck::Element& e : check_.worst) {
        for (std::size_t a = 0; a < 4; ++a)
            for (std::size_t b = 0; b < a; ++b)
                notes.lines.push_back({pixel(e.node[a]), pixel(e.node[b]), kFaultColor});
        notes.tags.push_back({pixel(e.node[0]), fmt::format("{}: {:.2g}", e.number, e.radius_ratio), kFaultColor});
    }
    for (const auto& [a, b] : check_.hinge_edge) notes.lines.push_back({pixel(a), pixel(b), kHingeColor});
    for (const std::int32_t node : check_.hinge_node)
        notes.lines.push_back({pixel(node), pixel(node) + Eigen::Vector2f(0.5F, 0.0F), kHingeColor});
    if (!check_.worst.empty())
        notes.legend.push_back({"worst elements (number: radius ratio)", kFaultColor, LegendEntry::Sign::area});
    if (!check_.hinge_edge.empty() || !check_.hinge_node.empty())
        notes.legend.push_back({"hinges", kHingeColor, LegendEntry::Sign::area});
}

Painter::Scene Painter::compose_mesh() {
    Scene scene;
    Annotation& notes = scene.notes;
    Eigen::AlignedBox3d box;
    for (const auto& x : tables_.position) box.extend(Eigen::Vector3d(x[0], x[1], x[2]));
    notes.title = tables_.name;
    notes.details = {fmt::format("{} nodes", tables_.position.size()),
                     fmt::format("{} on the surface", surface_.nodes()), fmt::format("{} patches", surface_.patches())};
    const Eigen::Vector3d &low = box.min(), &high = box.max();
    notes.second = fmt::format("x {:.4g} to {:.4g}, y {:.4g} to {:.4g}, z {:.4g} to {:.4g} m", low.x(), high.x(),
                               low.y(), high.y(), low.z(), high.z());
    notes.legend = {{"touchable", kTouchableColor, LegendEntry::Sign::area}};
    add_place(notes);
    add_faults(notes);
    return scene;
}

const Image& Painter::paint(const ContactFrame& frame, const Ranges& ranges) {
    const Scene scene = compose(frame, ranges);
    renderer_.draw(surface_, scene.markers, scene.shading, image_);
    annotate(image_, scene.notes);
    if (view_.exaggeration != 1.0) deform(frame);  // surface() is as it is
    return image_;
}

const Image& Painter::paint_mesh() {
    const Scene scene = compose_mesh();
    renderer_.draw(surface_, {}, {}, image_);
    annotate(image_, scene.notes);
    return image_;
}

void Painter::figure(const ContactFrame& frame, const Ranges& ranges, const std::filesystem::path& path) {
    const Scene scene = compose(frame, ranges);
    draw_figure(path, view_, renderer_.camera(), renderer_.size_m(), surface_, scene.shading, scene.markers,
                scene.notes);
    if (view_.exaggeration != 1.0) deform(frame);
}

void Painter::figure_mesh(const std::filesystem::path& path) {
    const Scene scene = compose_mesh();
    draw_figure(path, view_, renderer_.camera(), renderer_.size_m(), surface_, {}, {}, scene.notes);
}

}  // namespace haptable
