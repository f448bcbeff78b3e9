// SPDX-License-Identifier: GPL-2.0-or-later
// [tool]: what it reads, and what becomes of its options.
#include "host/scene/tool.hpp"

#include <nlohmann/json.hpp>

#include "host/base/scene_options.hpp"
#include "host/scene/keys.hpp"
#include "tests/host/scene/scene_file.hpp"

namespace haptable::test {
namespace {

class ToolScene : public SceneFile {
protected:
    Scene read(const std::string& tool) const {
        return SceneFile::read(
            "name = \"a\"\n[mesh]\ngenerate = \"cube\"\n[material]\nyoung = 1000\npoisson = 0.3\n"
            "[[fixed]]\nbelow = 0\n[contact]\nforce = \"pressure-mask\"\nmask_radius = 0.002\n" +
            tool);
    }
};

TEST_F(ToolScene, PointsByHand) {
    const Scene scene = read(
        "[tool]\npoints = [[-0.004, 0, 0], [0.004, 0, 0.001]]\nmax_torque = 0.1\nstiffness = 900\nturn_stiffness = "
        "2\n");
    ASSERT_TRUE(scene.tool);
    EXPECT_FALSE(scene.tool->shape);
    EXPECT_EQ(scene.tool->point_m, (std::vector<std::array<double, 3>>{{-0.004, 0, 0}, {0.004, 0, 0.001}}));
    EXPECT_EQ(scene.tool->max_torque_n_m, 0.1);
    EXPECT_EQ(scene.tool->stiffness_n_per_m, 900.0);
    EXPECT_EQ(scene.tool->turn_stiffness_n_m_per_rad, 2.0);
    EXPECT_FALSE(read("").tool);
}

TEST_F(ToolScene, Shape) {
    const Scene scene =
        read("[tool]\nshape = \"mesh\"\nfile = \"blade.stl\"\nscale = 0.001\npoints = 12\nangle = 30\n");
    ASSERT_TRUE(scene.tool && scene.tool->shape);
    const ToolShape& shape = *scene.tool->shape;
    EXPECT_EQ(shape.kind, ToolShape::Kind::kMesh);
    EXPECT_EQ(shape.points, 12);
    EXPECT_EQ(shape.file, folder_.path() / "blade.stl");
    EXPECT_EQ(shape.scale_m, 0.001);
    EXPECT_EQ(shape.angle_deg, 30.0);
    EXPECT_EQ(read("[tool]\nshape = \"sphere\"\nradius = 0.01\npoints = 7\n").tool->shape->angle_deg, 60.0);
}

/// Tables are of the points as they are sampled: what moves one changes the hash; a scene without a tool has no key of
/// it.
TEST_F(ToolScene, HashedByItsPoints) {
    Scene scene = read("[tool]\nshape = \"disc\"\nradius = 0.01\npoints = 2\n");
    scene.tool->point_m = {{0.001, 0, 0}, {0.002, 0, 0}};
    const std::string before = text_of_tables(options_of(scene));
    EXPECT_EQ(options_of(scene).at("tool.points"), nlohmann::ordered_json(scene.tool->point_m));
    scene.tool->point_m[0][0] = 0.0011;
    EXPECT_NE(text_of_tables(options_of(scene)), before);
    EXPECT_EQ(text_of_tables(options_of(read(""))).find("tool"), std::string::npos);
}

}  // namespace
}  // namespace haptable::test
