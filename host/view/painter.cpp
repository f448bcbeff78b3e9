// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/painter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/tables/small_strain.hpp"
#include "host/view/annotate.hpp"
#include "host/view/colormap.hpp"

namespace haptable {

namespace {

constexpr float kLongestArrow = 0.23F;  // of the body's size
// Ranges of a session in which nothing has moved: some scale has to stand there.
constexpr double kLeastRange_m = 1e-6;
constexpr double kRestRange_m = 1e-3;

Eigen::Vector3f to_float(const Eigen::Vector3d& v) { return v.cast<float>(); }

}  // namespace

Painter::Painter(const Tables& tables, const std::filesystem::path& folder, const ViewOptions& view, bool deform)
    : tables_(tables), small_strain_m_(read_small_strain_depth(folder)), surface_(tables), renderer_(view, surface_) {
    if (deform) deformation_.emplace(tables, folder);
}

void Painter::deform(const ContactFrame& frame) { surface_.deform(deformation_->displace(frame.loads)); }

void Painter::measure(const ContactFrame& frame, Ranges& ranges) {
    deform(frame);
    for (const Eigen::Vector3f& u : surface_.displacement_m)
        ranges.displacement_m = std::max(ranges.displacement_m, static_cast<double>(u.norm()));
    ranges.force_n = std::max(ranges.force_n, frame.force_n.norm());
}

Markers Painter::markers(const ContactFrame& frame, const Ranges& ranges) const {
    Markers markers;
    if (frame.finger_known) markers.finger = to_float(frame.finger_m);
    if (!frame.contact) return markers;
    markers.god_object = to_float(frame.god_object_m);
    if (ranges.force_n > 0.0)
        markers.arrow_tip = to_float(frame.god_object_m) +
                            kLongestArrow * renderer_.size_m() * to_float(frame.force_n / ranges.force_n);
    return markers;
}

const Image& Painter::paint(const ContactFrame& frame, const Ranges& ranges) {
    deform(frame);
    surface_.update_normals();
    const double range_m = ranges.displacement_m > kLeastRange_m ? ranges.displacement_m : kRestRange_m;
    const Markers shown = markers(frame, ranges);
    renderer_.draw(surface_, shown, static_cast<float>(range_m), image_);

    Annotation notes;
    notes.title = tables_.name;
    const double depth_mm = frame.contact ? 1e3 * (frame.finger_m - frame.god_object_m).norm() : 0.0;
    notes.details = {fmt::format("t = {:.3f} s", frame.time_s), fmt::format("tick {}", frame.number),
                     fmt::format("u = {:.2f} mm", depth_mm), fmt::format("|F| = {:.3f} N", frame.force_n.norm())};
    if (small_strain_m_ && depth_mm > 1e3 * *small_strain_m_)
        notes.warning = fmt::format("beyond small strain ({:.2g} mm): a rubber's force would be off by 10 % and more",
                                    1e3 * *small_strain_m_);
    notes.range_mm = 1e3 * range_m;
    notes.legend = {
        {"finger", kFingerColor}, {"god-object", kGodObjectColor}, {"force on the finger", kArrowColor, true}};
    if (shown.arrow_tip && frame.force_n.norm() > 0.0) {
        notes.label = fmt::format("{:.{}f} N", frame.force_n.norm(), frame.force_n.norm() < 0.0995 ? 3 : 2);
        notes.label_px = renderer_.camera().pixel(*shown.arrow_tip);
        notes.label_direction = *notes.label_px - renderer_.camera().pixel(*shown.god_object);
    }
    annotate(image_, notes);
    return image_;
}

const Image& Painter::paint_mesh() {
    renderer_.draw(surface_, {}, 0.0F, image_);
    Annotation notes;
    notes.title = tables_.name;
    notes.details = {fmt::format("{} nodes", tables_.position.size()),
                     fmt::format("{} on the surface", surface_.nodes()), fmt::format("{} patches", surface_.patches())};
    annotate(image_, notes);
    return image_;
}

}  // namespace haptable
