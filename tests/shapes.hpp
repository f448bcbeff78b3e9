// SPDX-License-Identifier: GPL-2.0-or-later
// Closed surfaces with a known shape, as tables of the servo. The blocks are made up (symmetric, positive definite,
// different at every node): contact and force only read them.
#pragma once

#include <Eigen/Core>
#include <random>
#include <string>
#include <vector>

#include "codegen/model.hpp"
#include "firmware/haptable_model.h"

namespace haptable::test {

/// A closed triangle surface, counter-clockwise from outside.
struct Shape {
    std::string name;
    std::vector<Eigen::Vector3d> point;              // [v]
    std::vector<std::array<std::int32_t, 3>> patch;  // [p]
};

Shape box_shape(int cells, const Eigen::Vector3d& side);  // cells a side, corner at the origin
Shape sphere_shape(int subdivisions, double radius);      // an icosahedron, divided; centre at the origin
Shape torus_shape(int around, int across, double major, double minor);
Shape l_shape(int cells, double side);       // a cube without one quarter: a concave crease
Shape hollow_shape(int cells, double side);  // a cube with a cavity of all cells but the outermost layer
Shape hinge_shape(int cells, double side);   // two quarters of a cube that share one edge: four patches meet there
Shape spindle_shape(int sides, double radius, double half);  // a double cone: its tips are vertices of `sides` patches
Shape fanned_disk_shape(int sides, double radius, double height);  // both faces fanned out from one point of the rim
Shape scaled(const Shape& shape, double factor);

/// A shape's tables and the struct of the servo that points into them.
class TestModel {
public:
    /// `fixed_below_z`: nodes lower than this have no block, they are rigid.
    explicit TestModel(const Shape& shape, double fixed_below_z = -1e9, GodObject god_object = GodObject::kNearest);
    TestModel(const TestModel&) = delete;
    TestModel& operator=(const TestModel&) = delete;

    const haptable_model* get() const { return &model_; }
    const Tables& tables() const { return tables_; }
    const ServoModel& servo() const { return servo_; }
    double size() const;                                        // diagonal, m
    Eigen::Vector3d corner(int patch, int c) const;             // of the servo's patch
    Eigen::Matrix3d stiffness(int vertex) const;                // S of a servo's vertex, from the double tables
    Eigen::Vector3d nearest(const Eigen::Vector3d& x) const;    // on the whole surface, by looking at all patches
    double signed_solid_angle(const Eigen::Vector3d& x) const;  // 4 pi inside, 0 outside

private:
    Tables tables_;
    ServoModel servo_;
    haptable_model model_{};
};

Eigen::Vector3d random_direction(std::mt19937& random);

/// The nearest point of a triangle, in double, by trying its plane, edges and corners.
Eigen::Vector3d nearest_on_triangle(const Eigen::Vector3d& x, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                    const Eigen::Vector3d& c);

}  // namespace haptable::test
