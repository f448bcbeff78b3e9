// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/annotate.hpp"

#include <cairo.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "host/view/camera.hpp"

namespace haptable {

namespace {

constexpr Rgb8 kInk{40, 40, 46};
constexpr Rgb8 kPaleInk{104, 104, 112};
constexpr Rgb8 kWarningInk{176, 42, 30};
constexpr double kReferenceHeight = 720.0;  // sizes below are pixels of a picture of 960 x 720
constexpr double kTitleBase = 38.0, kWarningBase = 62.0;
constexpr double kLabelBelow = 28.0;  // of the line above it, base to base

/// A cairo pen over an image. Lengths as in a picture of the reference height.
class Pen {
public:
    explicit Pen(Image& image)
        : unit_(reference_px(image.width, image.height) / kReferenceHeight),
          surface_(cairo_image_surface_create_for_data(reinterpret_cast<unsigned char*>(image.pixel.data()),
                                                       CAIRO_FORMAT_RGB24, image.width, image.height, 4 * image.width)),
          cairo_(cairo_create(surface_)) {
        cairo_scale(cairo_, unit_, unit_);
        width = image.width / unit_;
        height = image.height / unit_;
    }
    ~Pen() {
        cairo_destroy(cairo_);
        cairo_surface_flush(surface_);
        cairo_surface_destroy(surface_);
    }
    Pen(const Pen&) = delete;
    Pen& operator=(const Pen&) = delete;

    void color(const Rgb8& c, double opacity = 1.0) {
        cairo_set_source_rgba(cairo_, c[0] / 255.0, c[1] / 255.0, c[2] / 255.0, opacity);
    }
    void font(double size, bool bold) {
        cairo_select_font_face(cairo_, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                               bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
        cairo_set_font_size(cairo_, size);
    }
    double advance(const std::string& text) {
        cairo_text_extents_t extents;
        cairo_text_extents(cairo_, text.c_str(), &extents);
        return extents.x_advance;
    }
    /// With its base line's beginning at (x, y).
    void text(double x, double y, const std::string& text) {
        cairo_move_to(cairo_, x, y);
        cairo_show_text(cairo_, text.c_str());
    }
    /// The same on a light seam, to be read over anything.
    void outlined_text(double x, double y, const std::string& text, const Rgb8& ink) {
        cairo_move_to(cairo_, x, y);
        cairo_text_path(cairo_, text.c_str());
        cairo_set_line_join(cairo_, CAIRO_LINE_JOIN_ROUND);
        cairo_set_line_width(cairo_, 4.0);
        color(kBackgroundColor, 0.85);
        cairo_stroke_preserve(cairo_);
        color(ink);
        cairo_fill(cairo_);
    }
    double unit() const { return unit_; }
    cairo_t* cairo() { return cairo_; }

    double width;
    double height;

private:
    double unit_;
    cairo_surface_t* surface_;
    cairo_t* cairo_;
};

void draw_title(Pen& pen, const Annotation& annotation) {
    constexpr double kLeft = 24.0, kGap = 28.0;
    double x = kLeft;
    pen.font(19.0, true);
    pen.color(kInk);
    pen.text(x, kTitleBase, annotation.title);
    x += pen.advance(annotation.title) + kGap;
    pen.font(15.5, false);
    pen.color(kPaleInk);
    for (const std::string& detail : annotation.details) {
        pen.text(x, kTitleBase, detail);
        x += pen.advance(detail) + kGap;
    }
    if (!annotation.warning.empty()) pen.outlined_text(kLeft, kWarningBase, annotation.warning, kWarningInk);
}

void draw_legend(Pen& pen, const std::vector<LegendEntry>& legend) {
    const double base = pen.height - 22.0;
    double x = 30.0;
    pen.font(14.5, false);
    for (const LegendEntry& entry : legend) {
        cairo_t* cairo = pen.cairo();
        pen.color(entry.color);
        if (entry.arrow) {
            cairo_set_line_width(cairo, 2.4);
            cairo_move_to(cairo, x - 7.0, base - 5.0);
            cairo_line_to(cairo, x + 5.0, base - 5.0);
            cairo_stroke(cairo);
            cairo_move_to(cairo, x + 13.0, base - 5.0);
            cairo_line_to(cairo, x + 3.0, base - 10.0);
            cairo_line_to(cairo, x + 3.0, base);
            cairo_close_path(cairo);
        } else {
            cairo_arc(cairo, x, base - 5.0, 6.0, 0.0, 2.0 * std::numbers::pi);
        }
        cairo_fill(cairo);
        x += entry.arrow ? 21.0 : 13.0;
        pen.color(kPaleInk);
        pen.text(x, base, entry.text);
        x += pen.advance(entry.text) + 30.0;
    }
}

/// The colours from 0, at the bottom, to the end of the range, with round numbers beside them.
void draw_bar(Pen& pen, double range_mm) {
    constexpr double kWidth = 17.0, kShare = 0.56, kTick = 5.0;
    const double length = kShare * kReferenceHeight;
    const double left = pen.width - (kBarMargin * kReferenceHeight) + 34.0;
    const double bottom = 0.5 * (pen.height + length);
    cairo_t* cairo = pen.cairo();
    cairo_pattern_t* colors = cairo_pattern_create_linear(0.0, bottom, 0.0, bottom - length);
    for (std::size_t k = 0; k < kColors; ++k) {
        const Rgb8& c = color_map()[k];
        cairo_pattern_add_color_stop_rgb(colors, static_cast<double>(k) / (kColors - 1), c[0] / 255.0, c[1] / 255.0,
                                         c[2] / 255.0);
    }
    cairo_rectangle(cairo, left, bottom - length, kWidth, length);
    cairo_set_source(cairo, colors);
    cairo_fill_preserve(cairo);
    cairo_pattern_destroy(colors);
    pen.color(kInk);
    cairo_set_line_width(cairo, 1.0);
    cairo_stroke(cairo);

    pen.font(14.5, false);
    constexpr double kRoundOff = 1e-3;  // 4.9999 mm ends with a tick 5 too
    const double step = nice_step(range_mm, 4);
    const int digits = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
    double widest = 0.0;
    for (int k = 0; k * step <= range_mm * (1.0 + kRoundOff); ++k) {
        const double y = bottom - length * (k * step / range_mm);
        cairo_move_to(cairo, left + kWidth, y);
        cairo_line_to(cairo, left + kWidth + kTick, y);
        cairo_stroke(cairo);
        const std::string number = fmt::format("{:.{}f}", k * step, digits);
        pen.text(left + kWidth + kTick + 4.0, y + 5.2, number);
        widest = std::max(widest, pen.advance(number));
    }
    const std::string name = "displacement (mm)";
    cairo_save(cairo);
    cairo_translate(cairo, left + kWidth + kTick + widest + 24.0, bottom - 0.5 * (length - pen.advance(name)));
    cairo_rotate(cairo, -0.5 * std::numbers::pi);
    pen.color(kPaleInk);
    pen.text(0.0, 0.0, name);
    cairo_restore(cairo);
}

/// Beyond the arrow's tip, or beside it where the arrow points up or down, but inside the picture and below the title.
void draw_label(Pen& pen, const Annotation& annotation) {
    const Eigen::Vector2f &at_px = *annotation.label_px, &direction = annotation.label_direction;
    const std::string& label = annotation.label;
    constexpr double kGap = 13.0, kHeadGap = 20.0, kHalfHeight = 6.0;
    pen.font(16.0, true);
    const double width = pen.advance(label);
    const bool steep = std::abs(direction.x()) < 0.5F * std::abs(direction.y());
    const bool left = !steep && direction.x() < 0.0F;
    const double top = kLabelBelow + (annotation.warning.empty() ? kTitleBase : kWarningBase);
    const double y = at_px.y() / pen.unit() + kHalfHeight, gap = y < top ? kHeadGap : kGap;  // beside the arrow's head
    const double x = at_px.x() / pen.unit() + (left ? -gap - width : gap);
    pen.outlined_text(std::clamp(x, 8.0, std::max(8.0, pen.width - width - 8.0)), std::clamp(y, top, pen.height - 50.0),
                      label, kInk);
}

}  // namespace

double nice_step(double range, int steps) {
    const double largest = range / steps;
    const double power = std::pow(10.0, std::floor(std::log10(largest)));
    for (const double factor : {5.0, 2.0})
        if (factor * power <= largest * (1.0 + 1e-9)) return factor * power;
    return power;
}

void annotate(Image& image, const Annotation& annotation) {
    Pen pen(image);
    draw_title(pen, annotation);
    draw_legend(pen, annotation.legend);
    if (annotation.range_mm > 0.0) draw_bar(pen, annotation.range_mm);
    if (annotation.label_px) draw_label(pen, annotation);
}

}  // namespace haptable
