// SPDX-License-Identifier: GPL-2.0-or-later
// What is seen in a picture, probed pixel by pixel.
#include <gtest/gtest.h>
#include <png.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/json.hpp"
#include "host/view/annotate.hpp"
#include "host/view/antialias.hpp"
#include "host/view/colormap.hpp"
#include "host/view/painter.hpp"
#include "host/view/png.hpp"
#include "tests/error_of.hpp"
#include "tests/host/view/cube_tables.hpp"
#include "tests/sealed.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3d;
using Eigen::Vector3f;

Rgb8 color_at(const Image& image, const Vector2f& pixel) {
    const std::uint32_t c = image.at(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
    return {static_cast<std::uint8_t>(c >> 16U), static_cast<std::uint8_t>(c >> 8U), static_cast<std::uint8_t>(c)};
}

/// Of a colour, whatever the light: red, green and blue as shares of their sum.
Vector3f hue(const Rgb8& color) {
    const Vector3f c(color[0], color[1], color[2]);
    return c / std::max(c.sum(), 1.0F);
}

bool is_background(std::uint32_t pixel) {
    const auto& b = kBackgroundColor;
    return pixel == (static_cast<std::uint32_t>(b[0]) << 16U | static_cast<std::uint32_t>(b[1]) << 8U | b[2]);
}

class ViewPicture : public ::testing::Test {
protected:
    ViewPicture() { remake({}); }

    void remake(const CubeOptions& options) {
        write_cube_tables(folder_.path(), options);
        tables_ = read_tables(folder_.path());
    }

    /// The finger presses on the middle of the top, 5 mm deep.
    ContactFrame press() const {
        ContactFrame frame;
        frame.finger_known = frame.contact = true;
        frame.god_object_m = {0.015, 0.015, 0.03};
        frame.finger_m = {0.015, 0.015, 0.025};
        const auto i = static_cast<std::size_t>(std::find(tables_.node_id.begin(), tables_.node_id.end(), kTop) -
                                                tables_.node_id.begin());
        const Vector3d load = Eigen::Map<const Eigen::Matrix3d>(tables_.stiffness[i].data()) * Vector3d(0, 0, -0.005);
        frame.loads = {{kTop, {0.0F, 0.0F, static_cast<float>(load.z())}}};
        frame.force_n = -load;
        return frame;
    }

    Image painted(const ContactFrame& frame, const ViewOptions& view = {}) {
        Painter painter(tables_, folder_.path(), view, true);
        Ranges ranges;
        painter.measure(frame, ranges);
        return painter.paint(frame, ranges);
    }

    static constexpr std::int32_t kTop = 112;  // the middle of the top of 5 x 5 x 5 nodes
    TemporaryFolder folder_;
    Tables tables_;
};

TEST_F(ViewPicture, ShowsSpheresWhereGodObjectAndFingerAre) {
    const ContactFrame frame = press();
    Painter painter(tables_, folder_.path(), {}, true);
    Ranges ranges;
    painter.measure(frame, ranges);
    const Image image = painter.paint(frame, ranges);
    const Camera& camera = painter.renderer().camera();
    // The arrow stands on the god-object and the rod hangs from it: look beside both, but within the sphere.
    const float radius = kSphereShare * painter.renderer().size_m();
    const Vector3f god = frame.god_object_m.cast<float>();
    const Vector2f beside(0.7F * radius * camera.pixels_per_m(god), 0.0F);
    for (const Vector2f& at : {Vector2f(camera.pixel(god) + beside), Vector2f(camera.pixel(god) - beside)})
        EXPECT_WITHIN((hue(color_at(image, at)) - hue(kGodObjectColor)).norm(), .epsilon = 0.2);
    const Vector3f finger = frame.finger_m.cast<float>();
    const Rgb8 seen = color_at(image, camera.pixel(finger) + 0.6F * beside);
    EXPECT_GT(seen[0], seen[2] + 40);  // vermilion, through the surface
    // Three radii aside there is neither.
    EXPECT_GT((hue(color_at(image, camera.pixel(god) + 4.5F * beside)) - hue(kGodObjectColor)).norm(), 0.2F);
}

// Of two fingers each has its colour, in contact or not, and no other: the page's (host/base/colors.inc).
TEST_F(ViewPicture, ShowsTwoFingersInTheirColours) {
    ContactFrame both;
    both.finger_known = true;
    both.finger_m = {0.008, 0.004, 0.045};
    both.others = {{.finger_m = {0.024, 0.004, 0.045}}};
    Painter painter(tables_, folder_.path(), {}, true);
    Ranges ranges;
    painter.measure(both, ranges);
    EXPECT_EQ(ranges.fingers, 2U);
    const Image image = painter.paint(both, ranges);
    const auto seen = [&](const Vector3d& at) {
        return hue(color_at(image, painter.renderer().camera().pixel(at.cast<float>())));
    };
    const auto first = seen(both.finger_m), second = seen(both.others[0].finger_m);
    EXPECT_LT((first - hue(kFingerColor[0])).norm(), 0.5F * (first - hue(kFingerColor[1])).norm());
    EXPECT_LT((second - hue(kFingerColor[1])).norm(), 0.5F * (second - hue(kFingerColor[0])).norm());
}

TEST_F(ViewPicture, ShowsAFingerThatIsInsideTheBody) {
    ContactFrame deep;
    deep.finger_known = true;
    deep.finger_m = {0.015, 0.015, 0.012};
    Painter painter(tables_, folder_.path(), {}, true);
    const Image with = painter.paint(deep, {});
    deep.finger_known = false;
    const Image without = painter.paint(deep, {});
    const Vector2f at = painter.renderer().camera().pixel({0.015F, 0.015F, 0.012F});
    EXPECT_GT(color_at(with, at)[0], color_at(without, at)[0] + 40);
    EXPECT_FALSE(is_background(without.at(static_cast<int>(at.x()), static_cast<int>(at.y()))));
}

/// Red ink under the title, where the finger is deeper than tables.json says that a linear body goes.
TEST_F(ViewPicture, SaysWhereADentIsBeyondSmallStrain) {
    const auto warned = [&](const char* small_strain) {
        auto facts = parse_json(read_file(folder_.path() / "tables.json"));
        facts["small_strain"] = parse_json(small_strain);
        write_file(folder_.path() / "tables.json", json_text(facts));
        const Image image = painted(press());
        int red = 0;
        for (int y = 44; y < 70; ++y)
            for (int x = 0; x < image.width / 2; ++x) {
                const Rgb8 c = color_at(image, Vector2f(static_cast<float>(x), static_cast<float>(y)));
                red += c[0] > c[1] + 60 && c[0] > c[2] + 60 ? 1 : 0;
            }
        return red > 100;
    };
    EXPECT_TRUE(warned(R"({"depth_m": 0.0049})"));
    EXPECT_FALSE(warned(R"({"depth_m": 0.0051})"));
    EXPECT_FALSE(warned("null"));
}

/// An arrow that ends in the title: its label stands below what is written there.
TEST(Annotations, TheArrowsLabelLeavesTitleAndWarningAlone) {
    for (const char* warning : {"", "beyond small strain"}) {
        Annotation notes;
        notes.title = "mouse";
        notes.warning = warning;
        notes.label_px = Vector2f(60.0F, 30.0F);
        const auto drawn = [&](const char* label) {
            Image image{960, 720, std::vector<std::uint32_t>(960 * 720, 0xFFFFFF)};
            notes.label = label;
            annotate(image, notes);
            return image;
        };
        const Image with = drawn("0.42 N"), without = drawn("");
        int lowest = 0, highest = with.height;
        for (int y = 0; y < with.height; ++y)
            for (int x = 0; x < with.width; ++x) {
                if (without.at(x, y) != 0xFFFFFF) lowest = y;
                if (with.at(x, y) != without.at(x, y)) highest = std::min(highest, y);
            }
        EXPECT_GT(lowest, 30);
        EXPECT_GT(highest, lowest) << warning;
        EXPECT_LT(highest, lowest + 30) << warning;
    }
}

/// Names of elements that lie together stand beside each other: none has less ink than alone.
TEST(Annotations, TagsDoNotLieOverEachOther) {
    const auto ink = [](const std::vector<Vector2f>& places) {
        Annotation notes;
        for (const Vector2f& at : places) notes.tags.push_back({at, "1055: 0.32", kFaultColor});
        Image image{960, 720, std::vector<std::uint32_t>(960 * 720, 0xFFFFFF)};
        annotate(image, notes);
        return std::count_if(image.pixel.begin(), image.pixel.end(),
                             [](std::uint32_t c) { return (c & 0xFFU) < 100U; });
    };
    for (const float y : {100.0F, 715.0F})
        EXPECT_EQ(ink({{400, y}, {404, y}, {390, y + 4}}), ink({{400, y}}) + ink({{404, y}}) + ink({{390, y}})) << y;
}

TEST_F(ViewPicture, ColoursByDisplacement) {
    const ContactFrame frame = press();
    Painter painter(tables_, folder_.path(), {}, true);
    Ranges ranges;
    painter.measure(frame, ranges);
    EXPECT_WITHIN(std::abs(ranges.displacement_m - 0.005), .count = 16, .epsilon = kFloat, .condition = 10.0,
                  .size = 0.005);
    const Image image = painter.paint(frame, ranges);
    const Camera& camera = painter.renderer().camera();
    // Low on the side, between the mesh lines, the body hardly moves; near the pressed node it moves most.
    const Vector3f low(0.0F, 0.0105F, 0.0012F);
    EXPECT_WITHIN((hue(color_at(image, camera.pixel(low))) - hue(color_map().front())).norm(), .epsilon = 0.2);
    std::size_t yellow = 0;
    for (const std::uint32_t p : image.pixel) {
        const int r = p >> 16U & 0xFF, g = p >> 8U & 0xFF, b = p & 0xFF;
        yellow += r > 150 && g > 180 && b < 110 ? 1 : 0;
    }
    EXPECT_GT(yellow, 200U);
}

TEST_F(ViewPicture, UntouchablePatchesAreGrey) {
    remake({.touch_above_m = 0.0149});
    const ContactFrame frame = press();
    Painter painter(tables_, folder_.path(), {}, true);
    Ranges ranges;
    painter.measure(frame, ranges);
    const Image image = painter.paint(frame, ranges);
    const Rgb8 low = color_at(image, painter.renderer().camera().pixel({0.0F, 0.0105F, 0.0012F}));
    EXPECT_WITHIN((hue(low) - hue(kNeutralColor)).norm(), .epsilon = 0.04);
    const Rgb8 high = color_at(image, painter.renderer().camera().pixel({0.0F, 0.0105F, 0.0285F}));
    EXPECT_GT((hue(high) - hue(kNeutralColor)).norm(), 0.08F);
}

TEST_F(ViewPicture, TheRestShapeSeenAlongADiagonalIsSymmetric) {
    ViewOptions view;
    view.azimuth = -135.0;
    Painter painter(tables_, folder_.path(), view, false);
    const Image image = painter.paint_mesh();
    const float axis = painter.renderer().camera().pixel({0.015F, 0.015F, 0.015F}).x();
    int rows = 0;
    for (int y = 100; y < image.height - static_cast<int>(kBottomMargin * 720.0F); ++y) {  // below the title
        int left = image.width, right = -1;
        // Beside and below it stand axes, legend and length.
        for (int x = 0; x < image.width - static_cast<int>(kBarMargin * 720.0F); ++x)
            if (!is_background(image.at(x, y))) left = std::min(left, x), right = x;
        if (right < 0) continue;
        EXPECT_WITHIN(std::abs(0.5F * static_cast<float>(left + right + 1) - axis), .epsilon = 1.6) << "row " << y;
        ++rows;
    }
    EXPECT_GT(rows, 300);
}

TEST_F(ViewPicture, EdgesAreThinAndDark) {
    Painter painter(tables_, folder_.path(), {}, false);
    const Image image = painter.paint_mesh();
    const Camera& camera = painter.renderer().camera();
    // Across the crease between top and the side x = 0, away from the other lines.
    const auto brightness = [&](const Vector3f& at) {
        const Rgb8 c = color_at(image, camera.pixel(at));
        return c[0] + c[1] + c[2];
    };
    EXPECT_LT(brightness({0.0F, 0.0115F, 0.03F}), 240);
    EXPECT_GT(brightness({0.001F, 0.0115F, 0.03F}), 400);
    EXPECT_GT(brightness({0.0F, 0.0115F, 0.0288F}), 300);
}

TEST_F(ViewPicture, TheSameFrameGivesTheSameBytes) {
    const std::string once = encode_png(painted(press()));
    EXPECT_EQ(once, encode_png(painted(press())));
    ContactFrame deeper = press();
    deeper.finger_m.z() -= 0.001;
    EXPECT_NE(once, encode_png(painted(deeper)));
}

/// A half plane under a slope, as one sample a pixel draws it, and the share of each pixel that it covers.
struct Slope {
    Image drawn{200, 120, std::vector<std::uint32_t>(200 * 120, 0xFFFFFFU)};
    std::vector<double> covered;
};

Slope slope(double rise) {
    Slope out;
    for (int y = 0; y < out.drawn.height; ++y)
        for (int x = 0; x < out.drawn.width; ++x) {
            const auto edge = [&](double at) { return 20.3 + rise * at; };
            double share = 0.0;
            for (int k = 0; k < 64; ++k) share += std::clamp(y + 1.0 - edge(x + (k + 0.5) / 64.0), 0.0, 1.0) / 64.0;
            out.covered.push_back(share);
            if (y + 0.5 > edge(x + 0.5)) out.drawn.pixel[static_cast<std::size_t>(y * out.drawn.width + x)] = 0x202020U;
        }
    return out;
}

/// Mean square difference to the covered share, in the middle of the picture.
double roughness(const Image& image, const std::vector<double>& covered) {
    double sum = 0.0;
    for (int y = 30; y < image.height - 30; ++y)
        for (int x = 40; x < image.width - 40; ++x) {
            const double white = (static_cast<double>(image.at(x, y) & 0xFFU) - 0x20) / (0xFF - 0x20);
            const double off = 1.0 - white - covered[static_cast<std::size_t>(y * image.width + x)];
            sum += off * off;
        }
    return sum;
}

// The straight edge that the steps stand for is found: what is left is a fraction of the staircase.
TEST(ViewSmoothing, AStaircaseBecomesAnEdge) {
    for (const double rise : {0.11, 0.23, 0.37, 0.55}) {
        Slope with = slope(rise);
        const double before = roughness(with.drawn, with.covered);
        PixelBox all;
        all.include({100.0F, 60.0F}, 200.0F);
        Smoothing smoothing;
        smoothing.run(with.drawn, all);
        EXPECT_LT(roughness(with.drawn, with.covered), 0.35 * before) << rise;
    }
}

TEST(ViewSmoothing, EvenPicturesAndWhatIsOutsideTheBoxStay) {
    Image even{40, 30, std::vector<std::uint32_t>(40 * 30, 0x123456U)};
    const std::vector<std::uint32_t> before = even.pixel;
    PixelBox all;
    all.include({20.0F, 15.0F}, 60.0F);
    Smoothing smoothing;
    smoothing.run(even, all);
    EXPECT_EQ(even.pixel, before);
    Slope with = slope(0.2);
    const Image drawn = with.drawn;
    PixelBox right;
    right.include({150.0F, 60.0F}, 40.0F);
    smoothing.run(with.drawn, right);
    std::size_t changed = 0;
    for (int y = 0; y < drawn.height; ++y)
        for (int x = 0; x < drawn.width; ++x) {
            changed += drawn.at(x, y) != with.drawn.at(x, y) ? 1 : 0;
            const bool inside = x >= 110 && x < 190 && y >= 20 && y < 100;
            EXPECT_TRUE(inside || drawn.at(x, y) == with.drawn.at(x, y));
        }
    EXPECT_GT(changed, 20U);
}

// Held parts have their colour, also where columns name no rows.
TEST_F(ViewPicture, HeldPartsAreNamedApart) {
    ViewOptions below;
    below.elevation = -40.0;
    for (const char* columns : {"surface", "none"}) {
        remake({.columns = columns});
        Painter painter(tables_, folder_.path(), below, false);
        const Image image = painter.paint_mesh();
        const Vector2f bottom = painter.renderer().camera().pixel({0.0105F, 0.0122F, 0.0F});
        const Vector3f seen = hue(color_at(image, bottom));
        EXPECT_LT((seen - hue(kHeldColor)).norm(), 0.5F * (seen - hue(kTouchableColor)).norm()) << columns;
        const Vector2f side = painter.renderer().camera().pixel({0.0F, 0.0105F, 0.0165F});
        const Vector3f beside = hue(color_at(image, side));
        EXPECT_LT((beside - hue(kTouchableColor)).norm(), 0.5F * (beside - hue(kHeldColor)).norm()) << columns;
    }
}

TEST_F(ViewPicture, TheArrowStaysInThePicture) {
    ContactFrame frame = press();
    frame.force_n *= 1.0 / frame.force_n.norm();
    ViewOptions view;
    view.zoom = 1.8;
    Painter painter(tables_, folder_.path(), view, true);
    Ranges ranges;
    painter.measure(frame, ranges);
    const Markers drawn = painter.markers(frame, ranges);
    const Vector2f tip = painter.renderer().camera().pixel(*drawn.arrow_tip);
    EXPECT_GE(tip.y(), 0.0F);
    EXPECT_LT(tip.y(), painter.renderer().camera().pixel(*drawn.god_object).y());
    // At its own length it would leave it.
    const Vector3f whole = *drawn.god_object + Vector3f(0.0F, 0.0F, 0.23F * painter.renderer().size_m());
    EXPECT_LT(painter.renderer().camera().pixel(whole).y(), 0.0F);
}

// Drawn larger, and kept as it is for ParaView.
TEST_F(ViewPicture, ExaggerationIsOfThePictureAlone) {
    const ContactFrame frame = press();
    ViewOptions view;
    view.exaggeration = 2.0;
    Painter plain(tables_, folder_.path(), {}, true), large(tables_, folder_.path(), view, true);
    Ranges ranges;
    plain.measure(frame, ranges);
    const Image once = plain.paint(frame, ranges), twice = large.paint(frame, ranges);
    EXPECT_NE(once.pixel, twice.pixel);
    const Markers drawn = large.markers(frame, ranges);
    EXPECT_WITHIN((*drawn.finger - Vector3f(0.015F, 0.015F, 0.02F)).norm(), .count = 8, .epsilon = kFloat,
                  .size = 0.03);
    for (std::size_t i = 0; i < plain.surface().nodes(); ++i)
        EXPECT_EQ(plain.surface().displacement_m[i], large.surface().displacement_m[i]);
}

// The rest shape shows over the dent, and nowhere else.
TEST_F(ViewPicture, TheGhostStandsWhereTheBodyWas) {
    ViewOptions view;
    view.ghost = true;
    const Image with = painted(press(), view), without = painted(press());
    std::size_t changed = 0;
    for (int y = 0; y < with.height; ++y)
        for (int x = 0; x < with.width; ++x) changed += with.at(x, y) != without.at(x, y) ? 1 : 0;
    EXPECT_GT(changed, 5000U);
    const Painter painter(tables_, folder_.path(), view, true);
    const Vector2f low = painter.renderer().camera().pixel({0.0F, 0.0105F, 0.0012F});
    EXPECT_EQ(color_at(with, low), color_at(without, low));
}

// The tables' positions have sagged: what is drawn goes from the shape without weight to them.
TEST_F(ViewPicture, ASagIsDrawnFromTheShapeWithoutWeight) {
    EXPECT_NE(error_of([&] { read_sag(tables_, folder_.path()); }).find("has no sag: give the scene a [gravity]"),
              std::string::npos);
    std::vector<double> sag_m;
    for (const auto& x : tables_.position) sag_m.insert(sag_m.end(), {0.0, 0.0, -0.05 * x[2]});
    write_npy<double>(folder_.path() / "sag.npy", {tables_.position.size(), 3}, sag_m);
    seal(folder_.path());
    const Sag sag = read_sag(tables_, folder_.path());
    ViewOptions view;
    view.exaggeration = 2.0;
    Painter painter(sag, folder_.path(), view);
    Ranges ranges;
    painter.measure({}, ranges);
    EXPECT_WITHIN(std::abs(ranges.displacement_m - 0.0015), .count = 4, .epsilon = kFloat, .size = 0.0015);
    const Image image = painter.paint({}, ranges);
    for (std::size_t i = 0; i < painter.surface().nodes(); ++i) {
        const auto& x = tables_.position[static_cast<std::size_t>(painter.surface().node_id[i])];
        const Vector3f drawn = painter.surface().rest_m[i] + painter.surface().displacement_m[i];
        EXPECT_WITHIN((drawn.cast<double>() - Vector3d(x[0], x[1], x[2])).norm(), .count = 8, .epsilon = kFloat,
                      .size = 0.03);
    }
    // The top, whose middle is drawn at twice its way, has the colour of the largest.
    const Vector2f top = painter.renderer().camera().pixel({0.016F, 0.017F, 0.0285F});
    EXPECT_LT((hue(color_at(image, top)) - hue(color_map().back())).norm(), 0.15F);
    view.color = "stress";
    EXPECT_THROW(Painter(sag, folder_.path(), view), Error);
    sag_m.pop_back();
    write_npy<double>(folder_.path() / "sag.npy", {sag_m.size()}, sag_m);
    seal(folder_.path());
    EXPECT_NE(error_of([&] { read_sag(tables_, folder_.path()); }).find("make the tables again"), std::string::npos);
}

// Nodal forces: the loaded node alone has a colour of the upper half.
TEST_F(ViewPicture, ColoursByNodalForce) {
    ViewOptions view;
    view.color = "force";
    Painter painter(tables_, folder_.path(), view, true);
    Ranges ranges;
    painter.measure(press(), ranges);
    EXPECT_WITHIN(std::abs(ranges.nodal_force_n - press().force_n.norm()), .count = 4, .epsilon = kFloat,
                  .size = ranges.nodal_force_n);
    const Image image = painter.paint(press(), ranges);
    // A cell away the body has moved by millimetres, and carries no force.
    const Rgb8 beside = color_at(image, painter.renderer().camera().pixel({0.0263F, 0.0242F, 0.0295F}));
    EXPECT_WITHIN((hue(beside) - hue(color_map().front())).norm(), .epsilon = 0.1);
}

TEST(ViewCamera, AnyAxisPointsUp) {
    for (const char* up : {"x", "y", "z", "-x", "-y", "-z"}) {
        const Eigen::Matrix3f rows = upright(up);
        EXPECT_EQ(rows.determinant(), 1.0F) << up;
        EXPECT_EQ(rows * rows.transpose(), Eigen::Matrix3f::Identity()) << up;
        const float sign = up[0] == '-' ? -1.0F : 1.0F;
        EXPECT_EQ(rows.row(2).transpose(), sign * Vector3f::Unit(up[up[0] == '-' ? 1 : 0] - 'x')) << up;
    }
    for (const char* none : {"", "w", "xy", "--x", "-"}) EXPECT_THROW(upright(none), Error) << none;
}

TEST_F(ViewPicture, WithAnotherAxisUpThatOneRisesInThePicture) {
    const DrawnSurface surface(tables_);
    ViewOptions view;
    view.up = "-x";
    const Renderer renderer(view, surface);
    const Vector2f low = renderer.camera().pixel({0.03F, 0.015F, 0.015F});
    const Vector2f high = renderer.camera().pixel({0.0F, 0.015F, 0.015F});
    EXPECT_LT(high.y(), low.y() - 100.0F);
    EXPECT_WITHIN(std::abs(high.x() - low.x()), .epsilon = 20.0);
}

// As vectors: well-formed, of every patch that is seen, the same bytes again; without a folder nothing and an error.
TEST_F(ViewPicture, AFigureIsWrittenWholeOrNotAtAll) {
    Painter painter(tables_, folder_.path(), {}, true);
    Ranges ranges;
    painter.measure(press(), ranges);
    const std::filesystem::path svg = folder_.path() / "a.svg", pdf = folder_.path() / "a.pdf";
    painter.figure(press(), ranges, svg);
    painter.figure(press(), ranges, pdf);
    const std::string text = read_file(svg), page = read_file(pdf);
    EXPECT_EQ(text.rfind("</svg>"), text.size() - 7);
    std::size_t paths = 0;
    for (std::size_t at = text.find("<path"); at != std::string::npos; at = text.find("<path", at + 1)) ++paths;
    EXPECT_GT(paths, 3U * 32U);  // of the cube's six faces three are seen
    EXPECT_EQ(page.substr(0, 5), "%PDF-");
    painter.figure(press(), ranges, pdf);
    EXPECT_EQ(read_file(pdf), page);
    EXPECT_THROW(painter.figure(press(), ranges, folder_.path() / "none" / "a.svg"), Error);
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "none"));
}

// What precompute found is drawn: an element in red over the surface.
TEST_F(ViewPicture, AMeshAloneShowsItsWorstElements) {
    const auto red = [&] {
        Painter painter(tables_, folder_.path(), {}, false);
        const Image image = painter.paint_mesh();
        return std::count_if(image.pixel.begin(), image.pixel.end(), [](std::uint32_t p) {
            return (p >> 16U & 0xFFU) > 180 && (p >> 8U & 0xFFU) < 60 && (p & 0xFFU) < 70;
        });
    };
    EXPECT_LT(red(), 20);  // of the axes' x
    auto facts = parse_json(read_file(folder_.path() / "tables.json"));
    facts["mesh"] = parse_json(R"({"hinge_edges_at": [], "hinge_nodes_at": [], "worst_elements": [
        {"tetrahedron": 7, "radius_ratio": 0.25, "nodes": [0, 4, 20, 112]},
        {"tetrahedron": 8, "radius_ratio": 0.5, "nodes": [0, 4, 20, 99999]}]})");
    write_file(folder_.path() / "tables.json", json_text(facts));
    EXPECT_GT(red(), 200);
}

TEST_F(ViewPicture, OneSampleShowsTheSamePictureWithRougherOutlines) {
    ViewOptions fast;
    fast.samples = 1;
    const Image rough = painted(press(), fast), smooth = painted(press());
    std::size_t different = 0;
    for (std::size_t k = 0; k < rough.pixel.size(); ++k)
        for (unsigned shift = 0; shift < 24; shift += 8) {
            const int a = rough.pixel[k] >> shift & 0xFF, b = smooth.pixel[k] >> shift & 0xFF;
            different += std::abs(a - b) > 16 ? 1 : 0;
        }
    EXPECT_GT(different, 0U);
    EXPECT_LT(different, rough.pixel.size() / 50);
}

TEST_F(ViewPicture, AFrameDoesNotDependOnTheOnesBefore) {
    Painter painter(tables_, folder_.path(), {}, true);
    Ranges ranges;
    painter.measure(press(), ranges);
    const Image first = painter.paint(press(), ranges);
    painter.paint({}, ranges);
    EXPECT_EQ(painter.paint(press(), ranges).pixel, first.pixel);
}

TEST_F(ViewPicture, TheBodyFillsTheFreePartOfAnySize) {
    for (const auto& [width, height] : {std::pair(960, 720), {400, 700}, {900, 300}}) {
        ViewOptions view;
        view.width = width;
        view.height = height;
        const DrawnSurface surface(tables_);
        const Renderer renderer(view, surface);
        Eigen::AlignedBox2f box;
        for (const Vector3f& p : surface.rest_m) box.extend(renderer.camera().pixel(p));
        const auto h = static_cast<float>(height), w = static_cast<float>(width);
        const float unit = reference_px(width, height);
        EXPECT_GE(box.min().x(), kSideMargin * unit - 1.0F);
        EXPECT_LE(box.max().x(), w - kBarMargin * unit + 1.0F);
        EXPECT_GE(box.min().y(), kTopMargin * unit - 1.0F);
        EXPECT_LE(box.max().y(), h - kBottomMargin * unit + 1.0F);
        const float across = (box.max().x() - box.min().x()) / (w - (kSideMargin + kBarMargin) * unit);
        const float down = (box.max().y() - box.min().y()) / (h - (kTopMargin + kBottomMargin) * unit);
        EXPECT_GT(std::max(across, down), 0.7F);
    }
}

TEST_F(ViewPicture, CamerasAnglesTurnTheView) {
    const DrawnSurface surface(tables_);
    ViewOptions view;
    view.azimuth = -90.0;
    view.elevation = 0.0;
    const Renderer front(view, surface);
    // From -y: x to the right, z up, and a point nearer to the eye (smaller y) farther from the middle.
    const auto pixel = [&](float x, float y, float z) { return front.camera().pixel({x, y, z}); };
    EXPECT_GT(pixel(0.03F, 0.0F, 0.0F).x(), pixel(0.0F, 0.0F, 0.0F).x() + 100.0F);
    EXPECT_LT(pixel(0.0F, 0.0F, 0.03F).y(), pixel(0.0F, 0.0F, 0.0F).y() - 100.0F);
    EXPECT_GT(pixel(0.03F, 0.0F, 0.0F).x() - pixel(0.0F, 0.0F, 0.0F).x(),
              pixel(0.03F, 0.03F, 0.0F).x() - pixel(0.0F, 0.03F, 0.0F).x());
    view.zoom = 2.0;
    const Renderer close(view, surface);
    EXPECT_GT(close.camera().pixels_per_m({0.015F, 0.015F, 0.015F}),
              1.9F * front.camera().pixels_per_m({0.015F, 0.015F, 0.015F}));
}

/// CIELAB, independent of the space in which the map is made (sRGB, D65: IEC 61966-2-1, CIE 15).
Vector3d cielab(const Rgb8& color) {
    Vector3d c;
    for (int i = 0; i < 3; ++i) {
        const double s = color[static_cast<std::size_t>(i)] / 255.0;
        c[i] = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
    }
    Eigen::Matrix3d to_xyz;
    to_xyz << 0.4124, 0.3576, 0.1805, 0.2126, 0.7152, 0.0722, 0.0193, 0.1192, 0.9505;
    const Vector3d t = (to_xyz * c).cwiseQuotient(Vector3d(0.9505, 1.0, 1.089));
    const auto f = [](double v) { return v > 0.008856 ? std::cbrt(v) : 7.787 * v + 16.0 / 116.0; };
    return {116.0 * f(t.y()) - 16.0, 500.0 * (f(t.x()) - f(t.y())), 200.0 * (f(t.y()) - f(t.z()))};
}

TEST(ViewColorMap, RisesInLightnessInEvenSteps) {
    constexpr std::size_t kStep = 17;  // 15 steps of the 256 colours: rounding to 8 bits does not count
    double least = 1e9, most = 0.0;
    for (std::size_t k = kStep; k < kColors; k += kStep) {
        const Vector3d a = cielab(color_map()[k - kStep]), b = cielab(color_map()[k]);
        EXPECT_GT(b.x(), a.x() + 1.0) << k;
        least = std::min(least, (b - a).norm());
        most = std::max(most, (b - a).norm());
    }
    EXPECT_LT(most, 2.5 * least);  // CIELAB itself is uniform to about a factor of two
    EXPECT_GT(cielab(color_map().back()).x() - cielab(color_map().front()).x(), 45.0);
}

TEST(ViewAnnotate, StepsAreRoundNumbers) {
    for (const auto& [range, step] : {std::pair(5.0, 1.0), {8.8, 2.0}, {0.037, 0.005}, {2000.0, 500.0}})
        EXPECT_WITHIN(std::abs(nice_step(range, 4) - step), .count = 16, .size = step);
    for (int k = -40; k < 40; ++k) {
        const double range = std::pow(1.29, k);
        const double steps = range / nice_step(range, 4);
        EXPECT_WITHIN(4.0 - steps, .count = 64);
        EXPECT_WITHIN(steps - 10.0, .count = 64);
    }
}

TEST(ViewPng, IsReadBackAsItWas) {
    const TemporaryFolder folder;
    Image image{7, 5, {}};
    for (std::uint32_t k = 0; k < 35; ++k) image.pixel.push_back(k * 0x00070301U & 0x00FFFFFFU);
    const std::filesystem::path path = folder.path() / "a.png";
    write_png(path, image);
    png_image header{};
    header.version = PNG_IMAGE_VERSION;
    ASSERT_TRUE(png_image_begin_read_from_file(&header, path.c_str()));
    ASSERT_EQ(header.width, 7U);
    ASSERT_EQ(header.height, 5U);
    header.format = PNG_FORMAT_RGB;
    std::vector<std::uint8_t> bytes(PNG_IMAGE_SIZE(header));
    ASSERT_TRUE(png_image_finish_read(&header, nullptr, bytes.data(), 0, nullptr));
    for (std::size_t k = 0; k < 35; ++k)
        EXPECT_EQ(image.pixel[k],
                  static_cast<std::uint32_t>(bytes[3 * k] << 16U | bytes[3 * k + 1] << 8U | bytes[3 * k + 2]));
    // Written beside and renamed: nothing else is left.
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(ViewPng, SaysWhichPathCannotBeWritten) {
    const std::string said = error_of([&] { write_png("/nonexistent-folder/a.png", {1, 1, {0}}); });
    EXPECT_NE(said.find("/nonexistent-folder/a.png"), std::string::npos);
}

}  // namespace
}  // namespace haptable::test
