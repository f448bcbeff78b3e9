// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/annotate.hpp"

#include <cairo.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "host/view/camera.hpp"

namespace haptable {

namespace {

constexpr Rgb8 kInk{40, 40, 46};
constexpr Rgb8 kPaleInk{104, 104, 112};
constexpr Rgb8 kWarningInk{176, 42, 30};
constexpr std::array<Rgb8, 3> kAxisInk{drawn_color("axis_x"), drawn_color("axis_y"), drawn_color("axis_z")};
constexpr double kReferenceHeight = 720.0;  // sizes below are pixels of a picture of 960 x 720
constexpr double kTitleBase = 38.0, kWarningBase = 62.0;
constexpr double kLabelBelow = 28.0;  // of the line above it, base to base

/// A cairo pen over a picture. Lengths as in a picture of the reference height.
class Pen {
public:
    Pen(cairo_t* cairo, int width_px, int height_px)
        : unit_(reference_px(width_px, height_px) / kReferenceHeight), cairo_(cairo) {
        cairo_save(cairo_);
        cairo_scale(cairo_, unit_, unit_);
        width = width_px / unit_;
        height = height_px / unit_;
    }
    ~Pen() { cairo_restore(cairo_); }
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
    if (!annotation.second.empty()) pen.text(kLeft, kWarningBase, annotation.second);
    if (!annotation.warning.empty()) pen.outlined_text(kLeft, kWarningBase, annotation.warning, kWarningInk);
}

/// At (x, y), in the colour that is set.
void draw_sign(cairo_t* cairo, LegendEntry::Sign sign, double x, double y) {
    if (sign == LegendEntry::Sign::dot) {
        cairo_arc(cairo, x, y, 6.0, 0.0, 2.0 * std::numbers::pi);
    } else if (sign == LegendEntry::Sign::area) {
        cairo_rectangle(cairo, x - 6.5, y - 6.5, 13.0, 13.0);
    } else {
        cairo_set_line_width(cairo, 2.4);
        cairo_move_to(cairo, x - 7.0, y);
        cairo_line_to(cairo, x + 5.0, y);
        cairo_stroke(cairo);
        cairo_move_to(cairo, x + 13.0, y);
        cairo_line_to(cairo, x + 3.0, y - 5.0);
        cairo_line_to(cairo, x + 3.0, y + 5.0);
        cairo_close_path(cairo);
    }
    cairo_fill(cairo);
}

void draw_legend(Pen& pen, const std::vector<LegendEntry>& legend) {
    const double base = pen.height - 22.0;
    double x = 30.0;
    pen.font(14.5, false);
    for (const LegendEntry& entry : legend) {
        cairo_t* cairo = pen.cairo();
        pen.color(entry.color);
        draw_sign(cairo, entry.sign, x, base - 5.0);
        x += entry.sign == LegendEntry::Sign::arrow ? 21.0 : 13.0;
        pen.color(kPaleInk);
        pen.text(x, base, entry.text);
        x += pen.advance(entry.text) + 26.0;
    }
}

/// The colours from 0, at the bottom, to the end of the range, with round numbers beside them.
void draw_bar(Pen& pen, const ColorBar& bar) {
    const double range = bar.range;
    constexpr double kWidth = 17.0, kShare = 0.56, kTick = 5.0;
    const double length = kShare * kReferenceHeight;
    const double left = pen.width - (kBarMargin * kReferenceHeight) + 34.0;
    const double bottom = 0.5 * (pen.height + length);
    cairo_t* cairo = pen.cairo();
    // By 33 of its stops, which lie nearer to the map than the eye sees: a gradient of cairo's costs by its stops.
    constexpr std::size_t kStops = 32;
    cairo_pattern_t* colors = cairo_pattern_create_linear(0.0, bottom, 0.0, bottom - length);
    for (std::size_t k = 0; k <= kStops; ++k) {
        const Rgb8& c = color_map()[k * (kColors - 1) / kStops];
        cairo_pattern_add_color_stop_rgb(colors, static_cast<double>(k) / kStops, c[0] / 255.0, c[1] / 255.0,
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
    const double step = nice_step(range, 4);
    const int digits = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
    double widest = 0.0;
    for (int k = 0; k * step <= range * (1.0 + kRoundOff); ++k) {
        const double y = bottom - length * (k * step / range);
        cairo_move_to(cairo, left + kWidth, y);
        cairo_line_to(cairo, left + kWidth + kTick, y);
        cairo_stroke(cairo);
        const std::string number = fmt::format("{:.{}f}", k * step, digits);
        pen.text(left + kWidth + kTick + 4.0, y + 5.2, number);
        widest = std::max(widest, pen.advance(number));
    }
    const std::string& name = bar.name;
    cairo_save(cairo);
    cairo_translate(cairo, left + kWidth + kTick + widest + 24.0, bottom - 0.5 * (length - pen.advance(name)));
    cairo_rotate(cairo, -0.5 * std::numbers::pi);
    pen.color(kPaleInk);
    pen.text(0.0, 0.0, name);
    cairo_restore(cairo);
}

/// The body's axes at the lower right, the farthest from the eye first.
void draw_axes(Pen& pen, const Eigen::Matrix3f& axes) {
    constexpr double kLength = 27.0;
    const double x = pen.width - 58.0, y = pen.height - 66.0;
    cairo_t* cairo = pen.cairo();
    std::array<int, 3> order{0, 1, 2};
    std::sort(order.begin(), order.end(), [&](int a, int b) { return axes(2, a) < axes(2, b); });
    pen.font(13.0, true);
    for (const int k : order) {
        const double right = kLength * static_cast<double>(axes(0, k)),
                     down = -kLength * static_cast<double>(axes(1, k));
        pen.color(kAxisInk[static_cast<std::size_t>(k)]);
        cairo_set_line_width(cairo, 2.2);
        cairo_move_to(cairo, x, y);
        cairo_line_to(cairo, x + right, y + down);
        cairo_stroke(cairo);
        const double length = std::max(std::hypot(right, down), 1e-9), gap = 9.0 / length;
        const std::string name(1, static_cast<char>('x' + k));
        // An axis that points at the eye has its name beside.
        const double name_x = length > 4.0 ? x + right * (1.0 + gap) : x - 10.0;
        const double name_y = length > 4.0 ? y + down * (1.0 + gap) : y - 8.0;
        pen.text(name_x - 0.5 * pen.advance(name), name_y + 4.5, name);
    }
}

/// A bar of a round length at the body's distance.
void draw_length(Pen& pen, double units_per_m) {
    constexpr double kLongest = 140.0, kEnd = 4.0;
    const double length_m = nice_step(kLongest / units_per_m, 1);
    const double right = pen.width - 120.0, left = right - length_m * units_per_m, y = pen.height - 24.0;
    cairo_t* cairo = pen.cairo();
    pen.color(kInk);
    cairo_set_line_width(cairo, 1.6);
    for (const auto& [x0, y0, x1, y1] : {std::array{left, y, right, y}, std::array{left, y - kEnd, left, y + kEnd},
                                         std::array{right, y - kEnd, right, y + kEnd}}) {
        cairo_move_to(cairo, x0, y0);
        cairo_line_to(cairo, x1, y1);
    }
    cairo_stroke(cairo);
    pen.font(13.5, false);
    const std::string name = fmt::format("{:g} mm", 1e3 * length_m);
    pen.outlined_text(0.5 * (left + right - pen.advance(name)), y - 8.0, name, kPaleInk);
}

void draw_notes(Pen& pen, const Annotation& annotation) {
    cairo_t* cairo = pen.cairo();
    const auto at = [&](const Eigen::Vector2f& px) { return Eigen::Vector2d(px.cast<double>() / pen.unit()); };
    cairo_set_line_cap(cairo, CAIRO_LINE_CAP_ROUND);
    for (const NoteLine& line : annotation.lines) {
        const Eigen::Vector2d from = at(line.from_px), to = at(line.to_px);
        cairo_move_to(cairo, from.x(), from.y());
        cairo_line_to(cairo, to.x(), to.y());
        pen.color(kBackgroundColor, 0.8);
        cairo_set_line_width(cairo, 4.0);
        cairo_stroke_preserve(cairo);
        pen.color(line.color);
        cairo_set_line_width(cairo, 2.0);
        cairo_stroke(cairo);
    }
    constexpr double kTagHeight = 15.0;
    pen.font(13.5, true);
    std::vector<Eigen::AlignedBox2d> taken;
    for (const NoteTag& tag : annotation.tags) {
        const double width = pen.advance(tag.text),
                     x = std::clamp(at(tag.at_px).x() + 8.0, 8.0, pen.width - width - 8.0);
        const double highest = 16.0, lowest = pen.height - 8.0;
        const double wanted = std::clamp(at(tag.at_px).y() - 6.0, highest, lowest);
        const auto box = [&](double y) {
            return Eigen::AlignedBox2d(Eigen::Vector2d(x, y - kTagHeight), Eigen::Vector2d(x + width, y));
        };
        const auto is_free = [&](double y) {
            return y >= highest && y <= lowest && std::none_of(taken.begin(), taken.end(), [&](const auto& other) {
                       return other.intersects(box(y));
                   });
        };
        double y = wanted;  // or the next place above or below that no other has
        for (double away = 0.0; away < pen.height && !is_free(y); ++away)
            y = is_free(wanted + away) ? wanted + away : wanted - away;
        taken.push_back(box(y));
        pen.outlined_text(x, y, tag.text, tag.color);
    }
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

void annotate(cairo_t* cairo, int width, int height, const Annotation& annotation) {
    Pen pen(cairo, width, height);
    draw_notes(pen, annotation);
    draw_title(pen, annotation);
    draw_legend(pen, annotation.legend);
    if (annotation.axes) draw_axes(pen, *annotation.axes);
    if (annotation.px_per_m > 0.0) draw_length(pen, annotation.px_per_m / pen.unit());
    if (annotation.bar.range > 0.0) draw_bar(pen, annotation.bar);
    if (annotation.label_px) draw_label(pen, annotation);
}

void annotate(Image& image, const Annotation& annotation) {
    cairo_surface_t* surface =
        cairo_image_surface_create_for_data(reinterpret_cast<unsigned char*>(image.pixel.data()), CAIRO_FORMAT_RGB24,
                                            image.width, image.height, 4 * image.width);
    cairo_t* cairo = cairo_create(surface);
    annotate(cairo, image.width, image.height, annotation);
    cairo_destroy(cairo);
    cairo_surface_flush(surface);
    cairo_surface_destroy(surface);
}

}  // namespace haptable
