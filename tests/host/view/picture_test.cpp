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

/// Red, green and blue, 0 to 255.
std::array<int, 3> channels(std::uint32_t pixel) {
    return {int(pixel >> 16U & 0xFFU), int(pixel >> 8U & 0xFFU), int(pixel & 0xFFU)};
}

/// Of a colour, whatever the light: red, green and blue as shares of their sum.
template <typename Color>
Vector3f hue(const Color& color) {
    const Vector3f c{float(color[0]), float(color[1]), float(color[2])};
    return c / std::max(c.sum(), 1.0F);
}
float off(const Vector3f& seen, const Rgb8& color) { return (seen - hue(color)).norm(); }
void expect_nearer(const Vector3f& seen, const Rgb8& to, const Rgb8& than) {
    EXPECT_LT(off(seen, to), 0.5F * off(seen, than));
}

/// Pixels for which is(r, g, b).
template <typename Is>
int count(const Image& image, Is is) {
    int number = 0;
    for (const std::uint32_t pixel : image.pixel) {
        const auto [r, g, b] = channels(pixel);
        number += is(r, g, b) ? 1 : 0;
    }
    return number;
}
/// Pixels of two pictures for which are(x, y) and that differ.
template <typename Are>
int count_changed(const Image& a, const Image& b, Are are) {
    int number = 0;
    for (int y = 0; y < a.height; ++y)
        for (int x = 0; x < a.width; ++x) number += are(x, y) && a.at(x, y) != b.at(x, y) ? 1 : 0;
    return number;
}
bool everywhere(int, int) { return true; }

bool is_background(std::uint32_t pixel) {
    const auto [r, g, b] = channels(pixel);
    return r == kBackgroundColor[0] && g == kBackgroundColor[1] && b == kBackgroundColor[2];
}

/// A picture of a frame, or of the mesh alone, and its painter.
struct Shot {
    Shot(const Tables& tables, const std::filesystem::path& folder, const std::optional<ContactFrame>& frame,
         const ViewOptions& view)
        : painter(tables, folder, view, frame.has_value()) {
        if (frame) painter.measure(*frame, ranges);
        image = frame ? painter.paint(*frame, ranges) : painter.paint_mesh();
    }
    const Camera& camera() const { return painter.renderer().camera(); }
    Vector2f pixel(const Vector3f& at) const { return camera().pixel(at); }
    std::array<int, 3> color(const Vector2f& at) const { return channels(image.at(int(at.x()), int(at.y()))); }
    std::array<int, 3> color(const Vector3f& at) const { return color(pixel(at)); }
    Vector3f hue_at(const Vector3f& at) const { return hue(color(at)); }

    Painter painter;
    Ranges ranges;
    Image image;
};

const Vector3f kLow(0.0F, 0.0105F, 0.0012F);  ///< on a side that is seen, between the mesh's lines

class ViewPicture : public WithCube {
protected:
    /// The finger presses on the middle of the top, 5 mm deep.
    ContactFrame press() const {
        ContactFrame frame;
        frame.finger_known = frame.contact = true;
        frame.god_object_m = {0.015, 0.015, 0.03};
        frame.finger_m = {0.015, 0.015, 0.025};
        const auto i =
            std::size_t(std::find(tables_.node_id.begin(), tables_.node_id.end(), kTop) - tables_.node_id.begin());
        const Vector3d load = Eigen::Map<const Eigen::Matrix3d>(tables_.stiffness[i].data()) * Vector3d(0, 0, -0.005);
        frame.loads = {{kTop, {0.0F, 0.0F, float(load.z())}}};
        frame.force_n = -load;
        return frame;
    }

    Shot shot(const std::optional<ContactFrame>& frame, const ViewOptions& view = {}) const {
        return {tables_, folder_.path(), frame, view};
    }
    Image painted(const ContactFrame& frame, const ViewOptions& view = {}) const { return shot(frame, view).image; }
    void tell(const char* key, const char* fact) const {
        auto facts = parse_json(read_file(folder_.path() / "tables.json"));
        facts[key] = parse_json(fact);
        write_file(folder_.path() / "tables.json", json_text(facts));
    }
    static ContactFrame finger_at(const Vector3d& at_m) {
        ContactFrame frame;
        frame.finger_known = true;
        frame.finger_m = at_m;
        return frame;
    }
    static constexpr std::int32_t kTop = 112;  // the middle of the top of 5 x 5 x 5 nodes
};

TEST_F(ViewPicture, ShowsSpheresWhereGodObjectAndFingerAre) {
    const Shot seen = shot(press());
    // The arrow stands on the god-object and the rod hangs from it: look beside both, but within the sphere.
    const float radius = kSphereShare * seen.painter.renderer().size_m();
    const Vector3f god = press().god_object_m.cast<float>();
    const Vector2f at = seen.pixel(god), beside(0.7F * radius * seen.camera().pixels_per_m(god), 0.0F);
    for (const float side : {1.0F, -1.0F})
        EXPECT_WITHIN(off(hue(seen.color(Vector2f(at + side * beside))), kGodObjectColor), .epsilon = 0.2);
    const Vector2f finger = seen.pixel(press().finger_m.cast<float>());
    const auto [r, g, b] = seen.color(Vector2f(finger + 0.6F * beside));
    EXPECT_GT(r, b + 40);  // vermilion, through the surface
    // Three radii aside there is neither.
    EXPECT_GT(off(hue(seen.color(Vector2f(at + 4.5F * beside))), kGodObjectColor), 0.2F);
}

// Of two fingers each has its colour, in contact or not, and no other: the page's (host/base/colors.inc).
TEST_F(ViewPicture, ShowsTwoFingersInTheirColours) {
    ContactFrame both = finger_at({0.008, 0.004, 0.045});
    both.others = {{.finger_m = {0.024, 0.004, 0.045}}};
    const Shot seen = shot(both);
    EXPECT_EQ(seen.ranges.fingers, 2U);
    expect_nearer(seen.hue_at({0.008F, 0.004F, 0.045F}), kFingerColor[0], kFingerColor[1]);
    expect_nearer(seen.hue_at({0.024F, 0.004F, 0.045F}), kFingerColor[1], kFingerColor[0]);
}

/// Red ink under the title, where the finger is deeper than tables.json says that a linear body goes.
TEST_F(ViewPicture, SaysWhereADentIsBeyondSmallStrain) {
    for (const auto& [small_strain, is_warned] :
         {std::pair(R"({"depth_m": 0.0049})", true), {R"({"depth_m": 0.0051})", false}, {"null", false}}) {
        tell("small_strain", small_strain);
        const Image image = painted(press());
        int red = 0;
        for (int y = 44; y < 70; ++y)
            for (int x = 0; x < image.width / 2; ++x) {
                const auto [r, g, b] = channels(image.at(x, y));
                red += r > g + 60 && r > b + 60 ? 1 : 0;
            }
        EXPECT_EQ(red > 100, is_warned) << small_strain;
    }
}

Image annotated(const Annotation& notes) {
    Image image{960, 720, std::vector<std::uint32_t>(960 * 720, 0xFFFFFF)};
    annotate(image, notes);
    return image;
}

/// An arrow that ends in the title: its label stands below what is written there.
TEST(Annotations, TheArrowsLabelLeavesTitleAndWarningAlone) {
    for (const char* warning : {"", "beyond small strain"}) {
        Annotation notes;
        notes.title = "mouse";
        notes.warning = warning;
        notes.label_px = Vector2f(60.0F, 30.0F);
        const Image without = annotated(notes);
        notes.label = "0.42 N";
        const Image with = annotated(notes);
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
        return count(annotated(notes), [](int, int, int b) { return b < 100; });
    };
    for (const float y : {100.0F, 715.0F})
        EXPECT_EQ(ink({{400, y}, {404, y}, {390, y + 4}}), ink({{400, y}}) + ink({{404, y}}) + ink({{390, y}})) << y;
}

TEST_F(ViewPicture, ColoursByDisplacement) {
    const Shot seen = shot(press());
    EXPECT_WITHIN(std::abs(seen.ranges.displacement_m - 0.005), .count = 16, .epsilon = kFloat, .condition = 10.0,
                  .size = 0.005);
    // Low on the side the body hardly moves; near the pressed node it moves most.
    EXPECT_WITHIN(off(seen.hue_at(kLow), color_map().front()), .epsilon = 0.2);
    EXPECT_GT(count(seen.image, [](int r, int g, int b) { return r > 150 && g > 180 && b < 110; }), 200);
}

TEST_F(ViewPicture, UntouchablePatchesAreGrey) {
    remake({.touch_above_m = 0.0149});
    const Shot seen = shot(press());
    EXPECT_WITHIN(off(seen.hue_at(kLow), kNeutralColor), .epsilon = 0.04);
    EXPECT_GT(off(seen.hue_at({0.0F, 0.0105F, 0.0285F}), kNeutralColor), 0.08F);
}

TEST_F(ViewPicture, TheRestShapeSeenAlongADiagonalIsSymmetric) {
    const Shot seen = shot(ContactFrame(), {.azimuth = -135.0});
    const Image& image = seen.image;
    const float axis = seen.pixel({0.015F, 0.015F, 0.015F}).x();
    int rows = 0;
    for (int y = 100; y < image.height - int(kBottomMargin * 720.0F); ++y) {  // below the title
        int left = image.width, right = -1;
        // Beside and below it stand axes, legend and length.
        for (int x = 0; x < image.width - int(kBarMargin * 720.0F); ++x)
            if (!is_background(image.at(x, y))) left = std::min(left, x), right = x;
        if (right < 0) continue;
        EXPECT_WITHIN(std::abs(0.5F * float(left + right + 1) - axis), .epsilon = 1.6) << "row " << y;
        ++rows;
    }
    EXPECT_GT(rows, 300);
}

TEST_F(ViewPicture, EdgesAreThinAndDark) {
    const Shot seen = shot({});
    // Across the crease between top and the side x = 0, away from the other lines.
    const auto brightness = [&](const Vector3f& at) {
        const auto [r, g, b] = seen.color(at);
        return r + g + b;
    };
    EXPECT_LT(brightness({0.0F, 0.0115F, 0.03F}), 240);
    EXPECT_GT(brightness({0.001F, 0.0115F, 0.03F}), 400);
    EXPECT_GT(brightness({0.0F, 0.0115F, 0.0288F}), 300);
}

TEST_F(ViewPicture, TheSameFrameGivesTheSameBytesWhateverCameBefore) {
    Shot seen = shot(press());
    const std::string once = encode_png(seen.image);
    EXPECT_EQ(once, encode_png(painted(press())));
    seen.painter.paint({}, seen.ranges);
    EXPECT_EQ(once, encode_png(seen.painter.paint(press(), seen.ranges)));
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
            if (y + 0.5 > edge(x + 0.5)) out.drawn.pixel[std::size_t(y * out.drawn.width + x)] = 0x202020U;
        }
    return out;
}

/// Mean square difference to the covered share, in the middle of the picture.
double roughness(const Image& image, const std::vector<double>& covered) {
    double sum = 0.0;
    for (int y = 30; y < image.height - 30; ++y)
        for (int x = 40; x < image.width - 40; ++x) {
            const double white = (double(image.at(x, y) & 0xFFU) - 0x20) / (0xFF - 0x20);
            const double off = 1.0 - white - covered[std::size_t(y * image.width + x)];
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
    const auto is_inside = [](int x, int y) { return x >= 110 && x < 190 && y >= 20 && y < 100; };
    EXPECT_GT(count_changed(drawn, with.drawn, is_inside), 20);
    EXPECT_EQ(count_changed(drawn, with.drawn, [&](int x, int y) { return !is_inside(x, y); }), 0);
}

// Held parts have their colour, also where columns name no rows.
TEST_F(ViewPicture, HeldPartsAreNamedApart) {
    for (const ColumnRows columns : {ColumnRows::kSurface, ColumnRows::kNone}) {
        SCOPED_TRACE(word(columns));
        remake({.columns = columns});
        const Shot seen = shot({}, {.elevation = -40.0});
        expect_nearer(seen.hue_at({0.0105F, 0.0122F, 0.0F}), kHeldColor, kTouchableColor);
        expect_nearer(seen.hue_at({0.0F, 0.0105F, 0.0165F}), kTouchableColor, kHeldColor);
    }
}

TEST_F(ViewPicture, TheArrowStaysInThePicture) {
    ContactFrame frame = press();
    frame.force_n.normalize();
    const Shot seen = shot(frame, {.zoom = 1.8});
    const Markers drawn = seen.painter.markers(frame, seen.ranges);
    const Vector2f tip = seen.pixel(*drawn.arrow_tip);
    EXPECT_GE(tip.y(), 0.0F);
    EXPECT_LT(tip.y(), seen.pixel(*drawn.god_object).y());
    // At its own length it would leave it.
    const Vector3f whole = *drawn.god_object + Vector3f(0.0F, 0.0F, 0.23F * seen.painter.renderer().size_m());
    EXPECT_LT(seen.pixel(whole).y(), 0.0F);
}

// Drawn larger, and kept as it is for ParaView.
TEST_F(ViewPicture, ExaggerationIsOfThePictureAlone) {
    const Shot plain = shot(press()), large = shot(press(), {.exaggeration = 2.0});
    EXPECT_NE(plain.image.pixel, large.image.pixel);
    const Markers drawn = large.painter.markers(press(), large.ranges);
    EXPECT_WITHIN((*drawn.finger - Vector3f(0.015F, 0.015F, 0.02F)).norm(), .count = 8, .epsilon = kFloat,
                  .size = 0.03);
    EXPECT_EQ(plain.painter.surface().displacement_m, large.painter.surface().displacement_m);
}

// The rest shape shows over the dent, and nowhere else.
TEST_F(ViewPicture, TheGhostStandsWhereTheBodyWas) {
    const Shot with = shot(press(), {.ghost = true}), without = shot(press());
    EXPECT_GT(count_changed(with.image, without.image, everywhere), 5000);
    EXPECT_EQ(with.color(kLow), without.color(kLow));
}

// The tables' positions have sagged: what is drawn goes from the shape without weight to them.
TEST_F(ViewPicture, ASagIsDrawnFromTheShapeWithoutWeight) {
    EXPECT_TRUE(fails_with([&] { read_sag(tables_, folder_.path()); }, "has no sag: give the scene a [gravity]"));
    write_file(folder_.path() / "body.json", "{}");
    seal(folder_.path());
    EXPECT_TRUE(fails_with([&] { read_sag(tables_, folder_.path()); }, "has no sag: a free body falls"));
    std::filesystem::remove(folder_.path() / "body.json");
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
    const Image& image = painter.paint({}, ranges);
    for (std::size_t i = 0; i < painter.surface().nodes(); ++i) {
        const auto& x = tables_.position[std::size_t(painter.surface().node_id[i])];
        const Vector3f drawn = painter.surface().rest_m[i] + painter.surface().displacement_m[i];
        EXPECT_WITHIN((drawn.cast<double>() - Vector3d(x[0], x[1], x[2])).norm(), .count = 8, .epsilon = kFloat,
                      .size = 0.03);
    }
    // The top, whose middle is drawn at twice its way, has the colour of the largest.
    const Vector2f top = painter.renderer().camera().pixel({0.016F, 0.017F, 0.0285F});
    EXPECT_LT(off(hue(channels(image.at(int(top.x()), int(top.y())))), color_map().back()), 0.15F);
    view.color = "stress";
    EXPECT_THROW(Painter(sag, folder_.path(), view), Error);
    sag_m.pop_back();
    write_npy<double>(folder_.path() / "sag.npy", {sag_m.size()}, sag_m);
    seal(folder_.path());
    EXPECT_TRUE(fails_with([&] { read_sag(tables_, folder_.path()); }, "make the tables again"));
}

// Nodal forces: the loaded node alone has a colour of the upper half.
TEST_F(ViewPicture, ColoursByNodalForce) {
    const Shot seen = shot(press(), {.color = "force"});
    EXPECT_WITHIN(std::abs(seen.ranges.nodal_force_n - press().force_n.norm()), .count = 4, .epsilon = kFloat,
                  .size = seen.ranges.nodal_force_n);
    // A cell away the body has moved by millimetres, and carries no force.
    EXPECT_WITHIN(off(seen.hue_at({0.0263F, 0.0242F, 0.0295F}), color_map().front()), .epsilon = 0.1);
}

TEST(ViewCamera, AnyAxisPointsUp) {
    for (const std::string up : {"x", "y", "z", "-x", "-y", "-z"}) {
        const Eigen::Matrix3f rows = upright(up);
        EXPECT_EQ(rows.determinant(), 1.0F) << up;
        EXPECT_EQ(rows * rows.transpose(), Eigen::Matrix3f::Identity()) << up;
        EXPECT_EQ(rows.row(2).transpose(), (up[0] == '-' ? -1.0F : 1.0F) * Vector3f::Unit(up.back() - 'x')) << up;
    }
    for (const char* none : {"", "w", "xy", "--x", "-"}) EXPECT_THROW(upright(none), Error) << none;
}

// As vectors: well-formed, of every patch that is seen, the same bytes again; without a folder nothing and an error.
TEST_F(ViewPicture, AFigureIsWrittenWholeOrNotAtAll) {
    Shot seen = shot(press());
    const auto figure = [&](const char* name) {
        seen.painter.figure(press(), seen.ranges, folder_.path() / name);
        return read_file(folder_.path() / name);
    };
    const std::string text = figure("a.svg"), page = figure("a.pdf");
    EXPECT_EQ(text.rfind("</svg>"), text.size() - 7);
    std::size_t paths = 0;
    for (std::size_t at = text.find("<path"); at != std::string::npos; at = text.find("<path", at + 1)) ++paths;
    EXPECT_GT(paths, 3U * 32U);  // of the cube's six faces three are seen
    EXPECT_EQ(page.substr(0, 5), "%PDF-");
    EXPECT_EQ(figure("a.pdf"), page);
    EXPECT_THROW(figure("none/a.svg"), Error);
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "none"));
}

// What precompute found is drawn: an element in red over the surface.
TEST_F(ViewPicture, AMeshAloneShowsItsWorstElements) {
    const auto is_red = [](int r, int g, int b) { return r > 180 && g < 60 && b < 70; };
    tell("mesh", R"({"hinge_edges_at": [], "hinge_nodes_at": [], "worst_elements": []})");
    EXPECT_LT(count(shot({}).image, is_red), 20);  // of the axes' x
    tell("mesh", R"({"hinge_edges_at": [], "hinge_nodes_at": [], "worst_elements": [
        {"tetrahedron": 7, "radius_ratio": 0.25, "nodes": [0, 4, 20, 112]},
        {"tetrahedron": 8, "radius_ratio": 0.5, "nodes": [0, 4, 20, 99999]}]})");
    EXPECT_GT(count(shot({}).image, is_red), 200);
}

TEST_F(ViewPicture, OneSampleShowsTheSamePictureWithRougherOutlines) {
    const Image rough = painted(press(), {.samples = 1}), smooth = painted(press());
    std::size_t different = 0;
    for (std::size_t k = 0; k < rough.pixel.size(); ++k)
        for (std::size_t c = 0; c < 3; ++c)
            different += std::abs(channels(rough.pixel[k])[c] - channels(smooth.pixel[k])[c]) > 16 ? 1 : 0;
    EXPECT_GT(different, 0U);
    EXPECT_LT(different, rough.pixel.size() / 50);
}

TEST_F(ViewPicture, TheBodyFillsTheFreePartOfAnySize) {
    for (const auto& [width, height] : {std::pair(960, 720), {400, 700}, {900, 300}}) {
        const DrawnSurface surface(tables_);
        const Renderer renderer({.width = width, .height = height}, surface);
        Eigen::AlignedBox2f box;
        for (const Vector3f& p : surface.rest_m) box.extend(renderer.camera().pixel(p));
        const float unit = reference_px(width, height);
        const Eigen::AlignedBox2f room(
            Vector2f(kSideMargin * unit, kTopMargin * unit),
            Vector2f(float(width) - kBarMargin * unit, float(height) - kBottomMargin * unit));
        EXPECT_TRUE((box.min() - room.min()).minCoeff() >= -1.0F && (room.max() - box.max()).minCoeff() >= -1.0F);
        EXPECT_GT(box.sizes().cwiseQuotient(room.sizes()).maxCoeff(), 0.7F);
    }
}

TEST_F(ViewPicture, CamerasAnglesTurnTheView) {
    const DrawnSurface surface(tables_);
    ViewOptions view{.azimuth = -90.0, .elevation = 0.0};
    const Renderer front(view, surface);
    // From -y: x to the right, z up, and a point nearer to the eye (smaller y) farther from the middle.
    const auto pixel = [&](float x, float y, float z) { return front.camera().pixel({x, y, z}); };
    const Vector2f right = pixel(0.03F, 0.0F, 0.0F) - pixel(0.0F, 0.0F, 0.0F);
    EXPECT_GT(right.x(), 100.0F);
    EXPECT_GT(right.x(), pixel(0.03F, 0.03F, 0.0F).x() - pixel(0.0F, 0.03F, 0.0F).x());
    EXPECT_LT(pixel(0.0F, 0.0F, 0.03F).y(), pixel(0.0F, 0.0F, 0.0F).y() - 100.0F);
    view.zoom = 2.0;
    const Vector3f middle = Vector3f::Constant(0.015F);
    EXPECT_GT(Renderer(view, surface).camera().pixels_per_m(middle), 1.9F * front.camera().pixels_per_m(middle));
    const Renderer turned({.up = "-x"}, surface);
    const Vector2f rises =
        turned.camera().pixel({0.0F, 0.015F, 0.015F}) - turned.camera().pixel({0.03F, 0.015F, 0.015F});
    EXPECT_LT(rises.y(), -100.0F);
    EXPECT_WITHIN(std::abs(rises.x()), .epsilon = 20.0);
}

/// CIELAB, independent of the space in which the map is made (sRGB, D65: IEC 61966-2-1, CIE 15).
Vector3d cielab(const Rgb8& color) {
    Vector3d c;
    for (int i = 0; i < 3; ++i) {
        const double s = color[std::size_t(i)] / 255.0;
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
        const double range = std::pow(1.29, k), steps = range / nice_step(range, 4);
        EXPECT_WITHIN(std::abs(steps - 7.0) - 3.0, .count = 64) << "4 to 10 of them";
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

}  // namespace
}  // namespace haptable::test
