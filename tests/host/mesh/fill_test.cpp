// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/mesh/fill.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstring>
#include <numbers>
#include <random>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/mesh/audit.hpp"
#include "host/mesh/read_mesh.hpp"
#include "host/mesh/surface.hpp"
#include "tests/error_of.hpp"
#include "tests/shapes.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/tolerance.hpp"

namespace haptable::test {
namespace {

namespace fs = std::filesystem;

/// Points and triangles, a line each; numbers begin with `first`.
std::string lines(const Shape& shape, const char* of_point, const char* of_triangle, int first) {
    std::string text;
    for (const auto& p : shape.point) text += fmt::format("{}{:.17g} {:.17g} {:.17g}\n", of_point, p.x(), p.y(), p.z());
    for (const auto& [a, b, c] : shape.patch)
        text += fmt::format("{} {} {} {}\n", of_triangle, a + first, b + first, c + first);
    return text;
}

std::string to_off(const Shape& shape) {
    return fmt::format("OFF\n{} {} 0\n", shape.point.size(), shape.patch.size()) + lines(shape, "", "3", 0);
}

std::string to_obj(const Shape& shape) { return "# an object\no shape\n" + lines(shape, "v ", "f", 1); }

std::string to_ply(const Shape& shape) {
    return fmt::format(
               "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n"
               "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
               shape.point.size(), shape.patch.size()) +
           lines(shape, "", "3", 0);
}

/// Every triangle has corners of its own, in float.
std::string to_stl(const Shape& shape) {
    std::string bytes(80, ' ');
    const auto put = [&](auto value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
    put(static_cast<std::uint32_t>(shape.patch.size()));
    for (const auto& patch : shape.patch) {
        for (int k = 0; k < 3; ++k) put(0.0F);
        for (std::int32_t i : patch)
            for (int axis = 0; axis < 3; ++axis) put(float(shape.point[std::size_t(i)][axis]));
        put(std::uint16_t{0});
    }
    return bytes;
}

void add(const Shape& other, const Eigen::Vector3d& shift, bool turned, Shape& shape) {
    const auto first = std::int32_t(shape.point.size());
    for (const auto& p : other.point) shape.point.emplace_back(p + shift);
    for (auto [a, b, c] : other.patch) {
        if (turned) std::swap(b, c);
        shape.patch.push_back({first + a, first + b, first + c});
    }
}

class Fill : public testing::Test {
protected:
    TetMesh fill(const std::string& text, const std::string& name, const FillTarget& target) {
        write_file(folder_.path() / name, text);
        return read_mesh(folder_.path() / name, ReadOptions{1.0, false, target});
    }
    TetMesh fill(const Shape& shape, const FillTarget& target) { return fill(to_off(shape), "a.off", target); }
    void expect_refused(const Shape& shape, const std::string& why, const FillTarget& target = {0.2, 0, false}) {
        EXPECT_TRUE(fails_with([&] { fill(shape, target); }, why));
    }
    static std::string notes_of(const TetMesh& mesh) { return fmt::format("{}", fmt::join(mesh.notes, "\n")); }
    /// Its nodes are about as many as was asked for.
    static void expect_nodes(const TetMesh& mesh, std::size_t asked, double share) {
        EXPECT_WITHIN(std::abs(double(mesh.position_m.size()) / double(asked) - 1.0), .epsilon = share)
            << notes_of(mesh);
    }
    /// One body without cavities, hinges or folds.
    static void expect_whole(const Audit& audit) {
        EXPECT_EQ(audit.bodies, 1U);
        EXPECT_EQ(audit.cavities + audit.folded + audit.hinge_edges + audit.hinge_nodes, 0U);
    }
    const TemporaryFolder folder_;
};

constexpr double kBall = 4.0 / 3.0 * std::numbers::pi;

/// A triangle lies edge^2 / 6 below the sphere in its middle; some edges are twice what was asked for, and the ball
/// that is filled is made of triangles too.
Bound lost(double edge) { return {.count = 6.0, .epsilon = edge * edge / 6.0, .size = 3.0 * kBall}; }

TEST_F(Fill, ABallOfEveryFormatIsABall) {
    const Shape ball = sphere_shape(3, 1.0);
    const std::pair<std::string, std::string> files[] = {
        {"a.off", to_off(ball)}, {"a.obj", to_obj(ball)}, {"a.ply", to_ply(ball)}, {"a.stl", to_stl(ball)}};
    for (const auto& [name, text] : files) {
        const Audit audit = audit_mesh(fill(text, name, {0.25, 0}));
        EXPECT_WITHIN(std::abs(audit.volume_m3 - kBall), lost(0.25)) << name;
        expect_whole(audit);
        EXPECT_EQ(audit.euler, 2);
        EXPECT_GT(audit.worst_ratio, 0.02);
    }
}

TEST_F(Fill, ItTellsHowFarItIs) {
    write_file(folder_.path() / "a.off", to_off(sphere_shape(4, 1.0)));
    std::vector<std::size_t> nodes;
    std::size_t expected = 0;
    const WatchFill watch = [&](std::size_t now, std::size_t about) {
        nodes.push_back(now);
        expected = about;
    };
    const TetMesh mesh = read_mesh(folder_.path() / "a.off", ReadOptions{1.0, false, {0.08, 0}, watch});
    const std::size_t count = mesh.position_m.size();
    ASSERT_FALSE(nodes.empty()) << "a second of work, looked at ten times a second";
    EXPECT_TRUE(std::is_sorted(nodes.begin(), nodes.end()));
    EXPECT_GT(nodes.back(), 0U);
    EXPECT_LT(nodes.back(), 2 * count);
    EXPECT_GT(expected, count / 2);
    EXPECT_LT(expected, 2 * count);
}

TEST_F(Fill, TheSizeIsWhatWasAskedFor) {
    const Shape ball = sphere_shape(4, 1.0);
    double sum = 0.0, count = 0.0;
    const TetMesh mesh = fill(ball, {0.2, 0});
    for (const Patch& patch : find_surface(mesh.tet).patch)
        for (std::size_t c = 0; c < 3; ++c, ++count)
            sum += (mesh.position_m[std::size_t(patch[c])] - mesh.position_m[std::size_t(patch[(c + 1) % 3])]).norm();
    EXPECT_WITHIN(std::abs(sum / count / 0.2 - 1.0), .epsilon = 0.3) << "a criterion for circumradii, not for edges";
    for (std::size_t nodes : {500U, 2000U}) expect_nodes(fill(ball, {0.0, nodes}), nodes, 0.09);
    EXPECT_THROW(fill(ball, {1e-3, 0}), Error);
    EXPECT_THROW(fill(ball, {}), Error);
}

// Also where one triangle of the file is inside out.
TEST_F(Fill, CreasesStaySharp) {
    Shape box = box_shape(2, {1, 1, 1});
    EXPECT_WITHIN(std::abs(audit_mesh(fill(box, {0.3, 0})).volume_m3 - 1.0), .count = 64);
    std::swap(box.patch[3][1], box.patch[3][2]);
    const TetMesh mended = fill(box, {0.3, 0});
    EXPECT_WITHIN(std::abs(audit_mesh(mended).volume_m3 - 1.0), .count = 64);
    EXPECT_TRUE(says(mended.notes.back(), "inside out"));
}

TEST_F(Fill, SameSurfaceSameMesh) {
    const TetMesh a = fill(sphere_shape(3, 1.0), {0.3, 0}), b = fill(sphere_shape(3, 1.0), {0.3, 0});
    EXPECT_EQ(a.tet, b.tet);
    EXPECT_EQ(a.position_m, b.position_m);
}

TEST_F(Fill, AHollowBallHasACavity) {
    Shape hollow = sphere_shape(3, 1.0);
    add(sphere_shape(2, 0.4), {0, 0, 0}, true, hollow);
    const Audit audit = audit_mesh(fill(hollow, {0.2, 0}));
    EXPECT_EQ(audit.cavities, 1U);
    EXPECT_EQ(audit.bodies, 1U);
    EXPECT_WITHIN(std::abs(audit.volume_m3 - kBall * (1.0 - 0.064)), lost(0.2));
}

/// As a scanner sees a ball: the noise makes edges sharper than any crease.
Shape noisy_ball() {
    Shape ball = sphere_shape(4, 1.0);
    std::mt19937 dice(3);
    std::uniform_real_distribution<double> noise(0.94, 1.06);
    for (auto& p : ball.point) p *= noise(dice);
    return ball;
}

TEST_F(Fill, TheNoiseOfAScanIsNoCrease) {
    const TetMesh mesh = fill(noisy_ball(), {0.0, 1000});
    const Audit audit = audit_mesh(mesh);
    expect_nodes(mesh, 1000, 0.1);
    EXPECT_WITHIN(std::abs(audit.volume_m3 / kBall - 1.0), .epsilon = 0.04) << "2 % of it is the noise itself";
    expect_whole(audit);
    EXPECT_TRUE(says(notes_of(mesh), "filled without its creases, "));
    EXPECT_TRUE(says(notes_of(mesh), " edges sharper than 75 degrees; with them: "));
}

/// A line (r, z) from pole to pole, turned about z.
Shape lathe(const std::vector<Eigen::Vector2d>& line, int sides) {
    Shape shape;
    const auto last = int(line.size()) - 1;
    shape.point.emplace_back(0, 0, line.front().y());
    for (int k = 1; k < last; ++k)
        for (int s = 0; s < sides; ++s) {
            const double angle = 2.0 * std::numbers::pi * s / sides;
            const auto& p = line[std::size_t(k)];
            shape.point.emplace_back(p.x() * std::cos(angle), p.x() * std::sin(angle), p.y());
        }
    shape.point.emplace_back(0, 0, line.back().y());
    const auto at = [&](int k, int s) -> std::int32_t {
        if (k == 0) return 0;
        return k == last ? 1 + (last - 1) * sides : 1 + (k - 1) * sides + s % sides;
    };
    for (int k = 0; k < last; ++k)
        for (int s = 0; s < sides; ++s) {
            if (k > 0) shape.patch.push_back({at(k, s), at(k, s + 1), at(k + 1, s)});
            if (k + 1 < last) shape.patch.push_back({at(k, s + 1), at(k + 1, s + 1), at(k + 1, s)});
        }
    return shape;
}

/// Outside a ball, inside another, and a neck between them.
Shape bottle(double neck) {
    constexpr double kOuter = 1.0, kInner = 0.6;
    const double top = std::asin(2.0 * neck / kOuter), lip = std::asin(2.0 * neck / kInner);
    std::vector<Eigen::Vector2d> line;
    for (int k = 0; k <= 40; ++k) {  // from the bottom
        const double angle = std::numbers::pi - (std::numbers::pi - top) * k / 40.0;
        line.emplace_back(kOuter * std::sin(angle), kOuter * std::cos(angle));
    }
    const double high = line.back().y() - 0.3 * neck, low = kInner * std::cos(lip) + 0.3 * neck;
    line.emplace_back(1.3 * neck, high);
    for (int k = 1; k < 10; ++k) line.emplace_back(neck, high + (low - high) * k / 10.0);
    line.emplace_back(1.3 * neck, low);
    for (int k = 0; k <= 40; ++k) {
        const double angle = lip + (std::numbers::pi - lip) * k / 40.0;
        line.emplace_back(kInner * std::sin(angle), kInner * std::cos(angle));
    }
    line.front().x() = line.back().x() = 0.0;
    return lathe(line, 24);
}

TEST_F(Fill, ACavityThatTheSurfaceLacksIsAnError) {
    EXPECT_EQ(audit_mesh(fill(bottle(0.2), {0.1, 0})).cavities, 0U);
    expect_refused(bottle(0.01), "it encloses 1 cavities, and its surface 0", {0.3, 0});
}

TEST_F(Fill, WhatBoundsNothingIsRefusedWithItsPlace) {
    const Shape box = box_shape(2, {1, 1, 1});
    Shape open = box, doubled = box, crossing = box;
    open.patch.pop_back();
    expect_refused(open, "3 open and 0 non-manifold edges (the first from (");
    doubled.patch.push_back(doubled.patch.front());
    expect_refused(doubled, "0 open and 3 non-manifold edges");
    add(box, {0.55, 0.45, 0.35}, false, crossing);
    expect_refused(crossing, "intersects itself");
    expect_refused(crossing, "the first near (");
    const Shape sheet{"sheet", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}};
    expect_refused(sheet, "bounds no body", {0.0, 500});
}

/// What a scanner leaves: noise, holes, triangles twice or turned, and one inside that belongs to nothing.
Shape scanned_ball() {
    Shape ball = sphere_shape(4, 1.0);
    std::mt19937 dice(7);
    std::uniform_real_distribution<double> noise(-0.01, 0.01), any(0.0, 1.0);
    for (auto& p : ball.point) p += Eigen::Vector3d(noise(dice), noise(dice), noise(dice));
    Shape scan{"scan", ball.point, {}};
    for (auto patch : ball.patch) {
        const double fate = any(dice);
        if (fate < 0.01) continue;
        if (fate < 0.02) std::swap(patch[0], patch[1]);
        scan.patch.push_back(patch);
        if (fate > 0.99) scan.patch.push_back(patch);
    }
    const auto first = std::int32_t(scan.point.size());
    scan.point.insert(scan.point.end(), {{0.1, 0.0, 0.0}, {0.0, 0.1, 0.0}, {0.0, 0.0, 0.1}});
    scan.patch.push_back({first, first + 1, first + 2});
    return scan;
}

TEST_F(Fill, AScanIsWrappedAndFilled) {
    for (const std::size_t nodes : {800U, 2000U}) {
        const TetMesh mesh = fill(scanned_ball(), {0.0, nodes});
        const Audit audit = audit_mesh(mesh);
        EXPECT_WITHIN(std::abs(audit.volume_m3 / kBall - 1.0), .epsilon = 0.02) << nodes;
        expect_nodes(mesh, nodes, 0.2);
        expect_whole(audit);  // the triangle inside is lost
        EXPECT_TRUE(says(notes_of(mesh), "wrapped before it was filled (the surface does not bound a body: "));
    }
}

// A hole that is closed, and how far from the scan that is: test_check_draws_how_far_a_wrap_is_from_its_scan.
TEST_F(Fill, AWrapIsMadeWhereTheSceneAsksForIt) {
    const Shape ball = sphere_shape(4, 1.0);
    const TetMesh asked = fill(ball, {0.0, 1000, true}), left = fill(ball, {0.0, 1000});
    EXPECT_WITHIN(std::abs(audit_mesh(asked).volume_m3 / kBall - 1.0), .epsilon = 0.02);
    EXPECT_TRUE(says(notes_of(asked), "(mesh.wrap = true)"));
    EXPECT_FALSE(asked.scan_distance_m.empty());
    EXPECT_TRUE(left.scan_distance_m.empty());
    EXPECT_EQ(notes_of(left).find("wrapped"), std::string::npos) << notes_of(left);
}

// Bodies that lie in one another become one, and the distances are of the file's surface.
TEST_F(Fill, BodiesThatIntersectAreWrappedTogether) {
    Shape crossing = box_shape(2, {1, 1, 1});
    add(box_shape(2, {1, 1, 1}), {0.5, 0.0, 0.0}, false, crossing);
    const Audit audit = audit_mesh(fill(crossing, {0.0, 1500}));
    EXPECT_WITHIN(std::abs(audit.volume_m3 - 1.5), .epsilon = 0.03);
    expect_whole(audit);
}

// CGAL's own first points, on rays from the middle of all, met one of the two.
TEST_F(Fill, SmoothBodiesAreAllFilled) {
    Shape two = sphere_shape(3, 1.0);
    add(sphere_shape(2, 0.15), {2.6, 0.0, 0.0}, false, two);
    for (const std::optional<bool> wrap : {std::optional<bool>(false), std::optional<bool>(true)}) {
        const Audit audit = audit_mesh(fill(two, {0.1, 0, wrap}));
        EXPECT_EQ(audit.bodies, 2U);
        EXPECT_WITHIN(std::abs(audit.volume_m3 - (1.0 + 0.003375) * kBall), lost(0.1));
    }
}

class OtherPeoplesSurfaces : public Fill {};  // a suite of its own runs beside the others

/// Other people's surfaces: with holes, inside out, or whole. Volumes: by the divergence theorem of those that are
/// closed, turned outwards; of the bunny by its winding number (Jacobson et al. 2013), over 6,000 points.
TEST_F(OtherPeoplesSurfaces, AreFilled) {
    struct Known {
        const char* file;
        double volume;
    };
    const Known all[] = {{"surf_pepper_14980.ply", 1.3536e5},
                         {"surf_featuretype_1722.stl", 11.628},
                         {"surf_bunny_open.ply", 7.49e-4},
                         {"surf_multibody.stl", 7.423e-3}};
    for (const auto& [file, volume] : all) {
        const fs::path path = fs::path("../shared/meshes") / file;
        if (!fs::exists(path)) GTEST_SKIP() << "no ../shared/meshes";
        const TetMesh mesh = read_mesh(path, ReadOptions{1.0, false, {0.0, 2000}});
        const Audit audit = audit_mesh(mesh);
        EXPECT_WITHIN(std::abs(audit.volume_m3 / volume - 1.0), .epsilon = 0.02) << file << "\n" << notes_of(mesh);
        expect_nodes(mesh, 2000, 0.2);
    }
}

}  // namespace
}  // namespace haptable::test
