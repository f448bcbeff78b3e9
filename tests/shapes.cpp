// SPDX-License-Identifier: GPL-2.0-or-later
#include "tests/shapes.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "codegen/in_memory.hpp"

namespace haptable::test {

namespace {

using Eigen::Vector3d;

/// Merges points that are equal, so that surfaces made face by face close.
class Weld {
public:
    explicit Weld(Shape& shape) : shape_(shape) {}

    std::int32_t add(const Vector3d& x) {
        const std::array<long, 3> key{std::lround(x.x() * 1e9), std::lround(x.y() * 1e9), std::lround(x.z() * 1e9)};
        const auto [it, fresh] = seen_.try_emplace(key, static_cast<std::int32_t>(shape_.point.size()));
        if (fresh) shape_.point.push_back(x);
        return it->second;
    }

    void quad(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
        const auto i = add(a), j = add(b), k = add(c), l = add(d);
        shape_.patch.push_back({i, j, k});
        shape_.patch.push_back({i, k, l});
    }

private:
    Shape& shape_;
    std::map<std::array<long, 3>, std::int32_t> seen_;
};

/// The surface of a set of unit cells on a grid.
Shape cells_shape(const std::string& name, int cells, const Vector3d& side,
                  const std::function<bool(int, int, int)>& solid) {
    Shape shape{name, {}, {}};
    Weld weld(shape);
    const auto inside = [&](int i, int j, int k) {
        return std::min({i, j, k}) >= 0 && std::max({i, j, k}) < cells && solid(i, j, k);
    };
    const auto at = [&](int i, int j, int k) { return Vector3d(side.cwiseProduct(Vector3d(i, j, k)) / cells); };
    for (int i = 0; i < cells; ++i)
        for (int j = 0; j < cells; ++j)
            for (int k = 0; k < cells; ++k) {
                if (!inside(i, j, k)) continue;
                const auto p = [&](int a, int b, int c) { return at(i + a, j + b, k + c); };
                if (!inside(i - 1, j, k)) weld.quad(p(0, 0, 0), p(0, 0, 1), p(0, 1, 1), p(0, 1, 0));
                if (!inside(i + 1, j, k)) weld.quad(p(1, 0, 0), p(1, 1, 0), p(1, 1, 1), p(1, 0, 1));
                if (!inside(i, j - 1, k)) weld.quad(p(0, 0, 0), p(1, 0, 0), p(1, 0, 1), p(0, 0, 1));
                if (!inside(i, j + 1, k)) weld.quad(p(0, 1, 0), p(0, 1, 1), p(1, 1, 1), p(1, 1, 0));
                if (!inside(i, j, k - 1)) weld.quad(p(0, 0, 0), p(0, 1, 0), p(1, 1, 0), p(1, 0, 0));
                if (!inside(i, j, k + 1)) weld.quad(p(0, 0, 1), p(1, 0, 1), p(1, 1, 1), p(0, 1, 1));
            }
    return shape;
}

/// A regular polygon around the z axis, counter-clockwise from above.
std::vector<Vector3d> circle(int sides, double radius, double z) {
    std::vector<Vector3d> point;
    for (int i = 0; i < sides; ++i) {
        const double a = 2 * std::numbers::pi * i / sides;
        point.emplace_back(radius * std::cos(a), radius * std::sin(a), z);
    }
    return point;
}

/// A symmetric positive definite block with stiffnesses between 50 and 400 N/m.
std::array<double, 9> made_up_block(std::mt19937& random) {
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    Eigen::Matrix3d a;
    for (int i = 0; i < 9; ++i) a(i / 3, i % 3) = uniform(random);
    const Eigen::Matrix3d s = 60.0 * a * a.transpose() + 50.0 * Eigen::Matrix3d::Identity();
    std::array<double, 9> block{};
    std::copy_n(s.data(), 9, block.begin());  // symmetric
    return block;
}

}  // namespace

Shape box_shape(int cells, const Vector3d& side) {
    return cells_shape("box", cells, side, [](int, int, int) { return true; });
}

Shape l_shape(int cells, double side) {
    return cells_shape("l-shape", cells, Vector3d::Constant(side),
                       [=](int i, int, int k) { return i < cells / 2 || k < cells / 2; });
}

Shape hollow_shape(int cells, double side) {
    const auto inner = [=](int i) { return i > 0 && i < cells - 1; };
    return cells_shape("hollow", cells, Vector3d::Constant(side),
                       [=](int i, int j, int k) { return !(inner(i) && inner(j) && inner(k)); });
}

Shape hinge_shape(int cells, double side) {
    return cells_shape("hinge", cells, Vector3d::Constant(side),
                       [=](int i, int, int k) { return (i < cells / 2) == (k < cells / 2); });
}

Shape spindle_shape(int sides, double radius, double half) {
    Shape shape{"spindle " + std::to_string(sides), circle(sides, radius, 0.0), {}};
    shape.point.emplace_back(0, 0, half);
    shape.point.emplace_back(0, 0, -half);
    for (int i = 0; i < sides; ++i) {
        const int next = (i + 1) % sides;
        shape.patch.push_back({i, next, sides});
        shape.patch.push_back({next, i, sides + 1});
    }
    return shape;
}

Shape fanned_disk_shape(int sides, double radius, double height) {
    Shape shape{"fanned disk", circle(sides, radius, 0.0), {}};
    for (const Vector3d& x : circle(sides, radius, height)) shape.point.push_back(x);
    for (int i = 0; i < sides; ++i) {
        const int next = (i + 1) % sides;
        shape.patch.push_back({i, next, sides + i});
        shape.patch.push_back({next, sides + next, sides + i});
        if (i == 0 || next == 0) continue;
        shape.patch.push_back({0, next, i});
        shape.patch.push_back({sides, sides + i, sides + next});
    }
    return shape;
}

Shape sphere_shape(int subdivisions, double radius) {
    Shape shape{"sphere", {}, {}};
    const double g = std::numbers::phi;
    for (int s : {-1, 1})
        for (int t : {-1, 1}) {
            shape.point.emplace_back(0, s, t * g);
            shape.point.emplace_back(s, t * g, 0);
            shape.point.emplace_back(t * g, 0, s);
        }
    std::vector<std::array<Vector3d, 3>> faces;
    const auto& p = shape.point;
    for (std::size_t a = 0; a < 12; ++a)
        for (std::size_t b = a + 1; b < 12; ++b)
            for (std::size_t c = b + 1; c < 12; ++c) {
                const auto edge = [&](std::size_t i, std::size_t j) {
                    return std::abs((p[i] - p[j]).norm() - 2) < 1e-9;
                };
                if (!edge(a, b) || !edge(b, c) || !edge(a, c)) continue;
                const bool outward = (p[b] - p[a]).cross(p[c] - p[a]).dot(p[a]) > 0;
                faces.push_back(outward ? std::array{p[a], p[b], p[c]} : std::array{p[a], p[c], p[b]});
            }
    for (int level = 0; level < subdivisions; ++level) {
        std::vector<std::array<Vector3d, 3>> finer;
        for (const auto& [a, b, c] : faces) {
            const Vector3d ab = (a + b) / 2, bc = (b + c) / 2, ca = (c + a) / 2;
            finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
        }
        faces = std::move(finer);
    }
    shape.point.clear();
    Weld weld(shape);
    for (const auto& face : faces) {
        std::array<std::int32_t, 3> patch{};
        for (std::size_t c = 0; c < 3; ++c) patch[c] = weld.add(radius * face[c].normalized());
        shape.patch.push_back(patch);
    }
    return shape;
}

Shape torus_shape(int around, int across, double major, double minor) {
    Shape shape{"torus", {}, {}};
    Weld weld(shape);
    const auto at = [&](int i, int j) {
        const double a = 2 * std::numbers::pi * (i % around) / around, b = 2 * std::numbers::pi * (j % across) / across;
        const double r = major + minor * std::cos(b);
        return Vector3d(r * std::cos(a), r * std::sin(a), minor * std::sin(b));
    };
    for (int i = 0; i < around; ++i)
        for (int j = 0; j < across; ++j) weld.quad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    return shape;
}

Shape scaled(const Shape& shape, double factor) {
    Shape out = shape;
    for (auto& x : out.point) x *= factor;
    return out;
}

TestModel::TestModel(const Shape& shape, double fixed_below_z, GodObject god_object) {
    std::mt19937 random(1);
    tables_.name = shape.name;
    tables_.rigid_stiffness_n_per_m = 1000.0;
    tables_.max_force_n = 8.5;
    tables_.scene_file = shape.name + ".toml";
    tables_.force = ForceLaw::kInterpolated;
    tables_.god_object = god_object;
    tables_.surface = tables_.patch = shape.patch;
    for (std::size_t i = 0; i < shape.point.size(); ++i) {
        const Vector3d& x = shape.point[i];
        tables_.position.push_back({x.x(), x.y(), x.z()});
        if (x.z() < fixed_below_z) continue;
        tables_.node_id.push_back(static_cast<std::int32_t>(i));
        tables_.stiffness.push_back(made_up_block(random));
    }
    servo_ = build_model(tables_);
    model_ = model_in_memory(tables_, servo_);
}

double TestModel::size() const { return static_cast<double>(servo_.tolerance_m) * 0x1p20; }

Vector3d TestModel::corner(int patch, int c) const {
    const auto vertex = servo_.patch[static_cast<std::size_t>(patch)][static_cast<std::size_t>(c)];
    return Eigen::Vector3f(servo_.vertex_m[vertex].data()).cast<double>();
}

Eigen::Matrix3d TestModel::stiffness(int vertex) const {
    if (static_cast<std::size_t>(vertex) >= servo_.free_count)
        return tables_.rigid_stiffness_n_per_m * Eigen::Matrix3d::Identity();
    return Eigen::Matrix3d(tables_.stiffness[static_cast<std::size_t>(vertex)].data());  // symmetric
}

Vector3d TestModel::nearest(const Vector3d& x) const {
    Vector3d best = corner(0, 0);
    for (int p = 0; p < static_cast<int>(servo_.patch.size()); ++p) {
        const Vector3d y = nearest_on_triangle(x, corner(p, 0), corner(p, 1), corner(p, 2));
        if ((y - x).squaredNorm() < (best - x).squaredNorm()) best = y;
    }
    return best;
}

double TestModel::signed_solid_angle(const Vector3d& x) const {
    double sum = 0.0;  // van Oosterom and Strackee 1983
    for (int p = 0; p < static_cast<int>(servo_.patch.size()); ++p) {
        const Vector3d a = corner(p, 0) - x, b = corner(p, 1) - x, c = corner(p, 2) - x;
        const double la = a.norm(), lb = b.norm(), lc = c.norm();
        sum += 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
    }
    return sum;
}

Vector3d random_direction(std::mt19937& random) {
    std::normal_distribution<double> normal;
    return Vector3d(normal(random), normal(random), normal(random)).normalized();
}

Vector3d nearest_on_triangle(const Vector3d& x, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    std::vector<Vector3d> candidates{a, b, c};
    const auto edge = [&](const Vector3d& p, const Vector3d& q) {
        const double t = std::clamp((x - p).dot(q - p) / (q - p).squaredNorm(), 0.0, 1.0);
        candidates.push_back(p + t * (q - p));
    };
    edge(a, b);
    edge(b, c);
    edge(c, a);
    const Vector3d n = (b - a).cross(c - a).normalized();
    const Vector3d foot = x - n.dot(x - a) * n;
    const auto left = [&](const Vector3d& p, const Vector3d& q) { return n.dot((q - p).cross(foot - p)) >= 0; };
    if (left(a, b) && left(b, c) && left(c, a)) candidates.push_back(foot);
    return *std::min_element(candidates.begin(), candidates.end(), [&](const Vector3d& p, const Vector3d& q) {
        return (p - x).squaredNorm() < (q - x).squaredNorm();
    });
}

}  // namespace haptable::test
