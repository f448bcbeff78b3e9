// SPDX-License-Identifier: GPL-2.0-or-later
// The painter's algorithm: M. E. Newell, R. G. Newell and T. L. Sancha, "A solution to the hidden surface problem", ACM
// annual conference 1972, without its splitting: a patch is before another one when its middle is.
#include "host/view/figure.hpp"

#include <cairo-pdf.h>
#include <cairo-svg.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/view/colormap.hpp"

namespace haptable {

namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float kLargestPiece_px = 14.0F;  // a side of what has one colour
constexpr int kMostPieces = 8;             // along a side

struct Destroy {
    void operator()(cairo_t* cairo) const { cairo_destroy(cairo); }
    void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
};

Vector3f unit_color(const Rgb8& c) { return Vector3f(c[0], c[1], c[2]) / 255.0F; }

/// The lamps of shaders.hpp, without the shine.
Vector3f lit(const Vector3f& color, const Vector3f& eye_normal) {
    static const Vector3f key = Vector3f(-0.45F, 0.80F, 0.65F).normalized();
    static const Vector3f fill = Vector3f(0.85F, 0.05F, 0.50F).normalized();
    const float sky = 0.5F + 0.5F * eye_normal.y();
    const float diffuse = 0.36F + 0.20F * sky + 0.46F * std::max(eye_normal.dot(key), 0.0F) +
                          0.24F * std::max(eye_normal.dot(fill), 0.0F);
    return (color.cwiseProduct(color) * diffuse).cwiseSqrt().cwiseMin(1.0F);
}

class Figure {
public:
    Figure(cairo_t* cairo, const Camera& camera, float size_m, const DrawnSurface& surface, const Shading& shading)
        : cairo_(cairo), camera_(camera), size_m_(size_m), surface_(surface), shading_(shading) {}

    void draw_surface(float line_px) {
        struct Far {
            float depth_m;
            std::size_t patch;
        };
        std::vector<Far> order;
        for (std::size_t p = 0; p < surface_.patches(); ++p) {
            const std::array<Vector3f, 3> x = corners(p);
            const Vector3f middle = (x[0] + x[1] + x[2]) / 3.0F;
            if (surface_.is_inside_out || (x[1] - x[0]).cross(x[2] - x[0]).dot(to_eye(middle)) > 0.0F)
                order.push_back({-eye(middle).z(), p});
        }
        std::stable_sort(order.begin(), order.end(), [](const Far& a, const Far& b) { return a.depth_m > b.depth_m; });
        for (const Far& far : order) {
            fill_patch(far.patch);
            stroke_patch(far.patch, line_px);
        }
    }

    void draw_markers(const Markers& markers, std::size_t number = 0) {
        for (const Markers& other : markers.others) draw_markers(other, number + 1);
        const float radius = kSphereShare * size_m_;
        if (markers.god_object && markers.finger) line(*markers.god_object, *markers.finger, 1.2F);
        if (markers.finger) ball(*markers.finger, radius, kFingerColor.at(number), markers.god_object ? 0.75 : 1.0);
        if (markers.god_object && markers.arrow_tip) arrow(*markers.god_object, *markers.arrow_tip);
        if (markers.god_object) ball(*markers.god_object, radius, kGodObjectColor, 1.0);
    }

private:
    Vector3f eye(const Vector3f& x) const { return (camera_.to_eye() * x.homogeneous()).head<3>(); }
    /// Not normalised.
    Vector3f to_eye(const Vector3f& x) const { return camera_.to_eye().topLeftCorner<3, 3>().transpose() * -eye(x); }
    std::array<Vector3f, 3> corners(std::size_t p) const {
        std::array<Vector3f, 3> x;
        for (int c = 0; c < 3; ++c) {
            const auto node = static_cast<std::size_t>(surface_.patch[p][c]);
            x[static_cast<std::size_t>(c)] = surface_.rest_m[node] + surface_.displacement_m[node];
        }
        return x;
    }
    void color(const Vector3f& c, double opacity = 1.0) {
        cairo_set_source_rgba(cairo_, static_cast<double>(c.x()), static_cast<double>(c.y()),
                              static_cast<double>(c.z()), opacity);
    }
    void move_to(const Vector2f& p) { cairo_move_to(cairo_, static_cast<double>(p.x()), static_cast<double>(p.y())); }
    void line_to(const Vector2f& p) { cairo_line_to(cairo_, static_cast<double>(p.x()), static_cast<double>(p.y())); }

    /// At area coordinates of a patch.
    Vector3f color_at(std::size_t p, const Vector3f& alpha) const {
        Vector3f normal = Vector3f::Zero();
        float value = 0.0F;
        for (int c = 0; c < 3; ++c) {
            normal += alpha[c] * surface_.normal[static_cast<std::size_t>(surface_.normal_of[p][c])];
            if (!shading_.value.empty())
                value += alpha[c] * shading_.value[static_cast<std::size_t>(surface_.patch[p][c])];
        }
        normal = (camera_.to_eye().topLeftCorner<3, 3>() * normal).normalized();
        if (normal.z() < 0.0F) normal = -normal;
        const bool colored = !shading_.value.empty() && shading_.range > 0.0F;
        const int plain = plain_color(surface_, p, colored);
        const float share = colored ? std::clamp(value / shading_.range, 0.0F, 1.0F) : 0.0F;
        const auto place = static_cast<std::size_t>(std::lround(share * static_cast<float>(kColors - 1)));
        return lit(unit_color(plain == 0 ? color_map()[place] : plain_color(plain)), normal);
    }

    void fill_patch(std::size_t p) {
        const std::array<Vector3f, 3> x = corners(p);
        std::array<Vector2f, 3> px;
        float longest = 0.0F;
        for (std::size_t c = 0; c < 3; ++c) px[c] = camera_.pixel(x[c]);
        for (std::size_t c = 0; c < 3; ++c) longest = std::max(longest, (px[(c + 1) % 3] - px[c]).norm());
        const bool plain = plain_color(surface_, p, !shading_.value.empty() && shading_.range > 0.0F) != 0;
        const int n = std::clamp(static_cast<int>(std::ceil(longest / kLargestPiece_px)), 1, plain ? 3 : kMostPieces);
        const auto at = [&](int i, int j) -> Vector3f {
            return Vector3f(static_cast<float>(n - i - j), static_cast<float>(i), static_cast<float>(j)) /
                   static_cast<float>(n);
        };
        for (int i = 0; i < n; ++i)
            for (int j = 0; i + j < n; ++j) {
                fill_piece(p, px, {at(i, j), at(i + 1, j), at(i, j + 1)});
                if (i + j + 1 < n) fill_piece(p, px, {at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
            }
    }

    /// With a hair of its own colour around it, or the background would shine through where pieces meet.
    void fill_piece(std::size_t p, const std::array<Vector2f, 3>& px, const std::array<Vector3f, 3>& alpha) {
        for (std::size_t k = 0; k < 3; ++k) {
            const Vector2f at = alpha[k][0] * px[0] + alpha[k][1] * px[1] + alpha[k][2] * px[2];
            k == 0 ? move_to(at) : line_to(at);
        }
        cairo_close_path(cairo_);
        color(color_at(p, (alpha[0] + alpha[1] + alpha[2]) / 3.0F));
        cairo_set_line_width(cairo_, 0.4);
        cairo_fill_preserve(cairo_);
        cairo_stroke(cairo_);
    }

    void stroke_patch(std::size_t p, float line_px) {
        const std::array<Vector3f, 3> x = corners(p);
        for (std::size_t c = 0; c < 3; ++c) {
            const bool crease = surface_.crease[p][c] != 0;
            move_to(camera_.pixel(x[(c + 1) % 3]));
            line_to(camera_.pixel(x[(c + 2) % 3]));
            color(Vector3f(0.09F, 0.09F, 0.13F), crease ? 0.9 : 0.45);
            cairo_set_line_width(cairo_, static_cast<double>(line_px) * (crease ? 1.2 : 0.5));
            cairo_stroke(cairo_);
        }
    }

    void line(const Vector3f& from, const Vector3f& to, float width_px) {
        move_to(camera_.pixel(from));
        line_to(camera_.pixel(to));
        color(unit_color(kArrowColor), 0.8);
        cairo_set_line_width(cairo_, static_cast<double>(width_px));
        cairo_stroke(cairo_);
    }

    void ball(const Vector3f& at, float radius_m, const Rgb8& ink, double opacity) {
        const Vector2f p = camera_.pixel(at);
        const float r = radius_m * camera_.pixels_per_m(at);
        cairo_pattern_t* shade =
            cairo_pattern_create_radial(p.x() - 0.35F * r, p.y() - 0.4F * r, 0.1F * r, p.x(), p.y(), r);
        const Vector3f c = unit_color(ink), light = 0.55F * c + Vector3f::Constant(0.45F), dark = 0.75F * c;
        const auto stop = [&](double offset, const Vector3f& v) {
            cairo_pattern_add_color_stop_rgba(shade, offset, static_cast<double>(v.x()), static_cast<double>(v.y()),
                                              static_cast<double>(v.z()), opacity);
        };
        stop(0.0, light), stop(0.5, c), stop(1.0, dark);
        cairo_arc(cairo_, p.x(), p.y(), r, 0.0, 2.0 * std::numbers::pi);
        cairo_set_source(cairo_, shade);
        cairo_fill(cairo_);
        cairo_pattern_destroy(shade);
    }

    void arrow(const Vector3f& from_m, const Vector3f& to_m) {
        const Vector2f from = camera_.pixel(from_m), to = camera_.pixel(to_m);
        const float length = (to - from).norm(), unit = size_m_ * camera_.pixels_per_m(from_m);
        if (!(length > 0.0F)) return;
        const float head = std::min(0.042F * unit, 0.5F * length), half = 0.37F * head;
        const Vector2f along = (to - from) / length, aside(-along.y(), along.x()), neck = to - head * along;
        color(unit_color(kArrowColor));
        cairo_set_line_width(cairo_, 0.011 * static_cast<double>(unit));
        move_to(from), line_to(neck);
        cairo_stroke(cairo_);
        move_to(to), line_to(neck + half * aside), line_to(neck - half * aside);
        cairo_close_path(cairo_);
        cairo_fill(cairo_);
    }

    cairo_t* cairo_;
    const Camera& camera_;
    float size_m_;
    const DrawnSurface& surface_;
    const Shading& shading_;
};

}  // namespace

bool is_figure(const std::filesystem::path& path) { return path.extension() == ".svg" || path.extension() == ".pdf"; }

void draw_figure(const std::filesystem::path& path, const ViewOptions& view, const Camera& camera, float size_m,
                 const DrawnSurface& surface, const Shading& shading, const Markers& markers, const Annotation& notes) {
    StagedPath beside(path);
    const std::string file = beside.path().string();
    const auto create = path.extension() == ".pdf" ? cairo_pdf_surface_create : cairo_svg_surface_create;
    const std::unique_ptr<cairo_surface_t, Destroy> sheet(create(file.c_str(), view.width, view.height));
    if (path.extension() == ".pdf")  // no date: same picture, same bytes
        cairo_pdf_surface_set_metadata(sheet.get(), CAIRO_PDF_METADATA_CREATE_DATE, "2000-01-01T00:00:00Z");
    const std::unique_ptr<cairo_t, Destroy> cairo(cairo_create(sheet.get()));
    cairo_set_line_join(cairo.get(), CAIRO_LINE_JOIN_ROUND);
    cairo_set_line_cap(cairo.get(), CAIRO_LINE_CAP_ROUND);
    cairo_set_source_rgb(cairo.get(), 1.0, 1.0, 1.0);
    cairo_paint(cairo.get());
    Figure figure(cairo.get(), camera, size_m, surface, shading);
    figure.draw_surface(1.1F / 720.0F * reference_px(view.width, view.height));
    figure.draw_markers(markers);
    annotate(cairo.get(), view.width, view.height, notes);
    cairo_show_page(cairo.get());
    cairo_surface_finish(sheet.get());
    if (const cairo_status_t status = cairo_surface_status(sheet.get()); status != CAIRO_STATUS_SUCCESS)
        throw Error(path.string() + ": cannot be written: " + cairo_status_to_string(status));
    beside.commit();
}

}  // namespace haptable
