// SPDX-License-Identifier: GPL-2.0-or-later
// clip = P M x: M turns and moves the point to the eye, P is the perspective of a lens of kFieldDegrees
#include "host/view/camera.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <vector>

#include "host/base/command_line.hpp"

namespace haptable {

namespace {

using Eigen::Matrix4f;
using Eigen::Vector3f;
using Eigen::Vector4f;

constexpr float kFieldDegrees = 24.0F;  // of the picture's height: a long lens, so that a cube looks like a cube
constexpr float kNear = 0.1F;           // of the distance to the centre
constexpr float kFar = 6.0F;

/// Rows: right, up, backwards, of an eye at the given angles.
Eigen::Matrix3f turn(const ViewOptions& view) {
    const double azimuth = view.azimuth * std::numbers::pi / 180.0;
    const double elevation = view.elevation * std::numbers::pi / 180.0;
    const Eigen::Vector3d back(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                               std::sin(elevation));
    const Eigen::Vector3d right(-std::sin(azimuth), std::cos(azimuth), 0.0);
    Eigen::Matrix3d rows;
    rows << right.transpose(), back.cross(right).transpose(), back.transpose();
    return rows.cast<float>();
}

/// The free part of the picture, in units where its height runs from -1 to 1.
struct Window {
    float left, right, bottom, top;
};

Window window(const ViewOptions& view) {
    const float aspect = static_cast<float>(view.width) / static_cast<float>(view.height);
    const float share = 2.0F * reference_px(view.width, view.height) / static_cast<float>(view.height);
    return {-aspect + share * kSideMargin, aspect - share * kBarMargin, -1.0F + share * kBottomMargin,
            1.0F - share * kTopMargin};
}

Eigen::AlignedBox3f box_of(std::span<const Vector3f> points) {
    Eigen::AlignedBox3f box;
    for (const Vector3f& point : points) box.extend(point);
    return box;
}

/// What the points cover of the plane 1 ahead of an eye at a distance: (x, y, z) is seen at (x, y) / (distance - z).
Eigen::AlignedBox2f spread(const std::vector<Vector3f>& seen, float distance) {
    Eigen::AlignedBox2f box;
    for (const Vector3f& p : seen) box.extend(Eigen::Vector2f(p.head<2>() / (distance - p.z())));
    return box;
}

/// The least distance at which the points cover no more than `room` of that plane, by bisection.
float fitting_distance(const std::vector<Vector3f>& seen, const Eigen::Array2f& room, float size) {
    const auto fits = [&](float distance) { return (spread(seen, distance).sizes().array() <= room).all(); };
    float near = 0.6F * size;  // more than half of the diagonal: no point is behind the eye
    float far = near;
    while (!fits(far) && far < 1e3F * size) far *= 2.0F;
    for (int step = 0; step < 24; ++step) {
        const float middle = 0.5F * (near + far);
        (fits(middle) ? far : near) = middle;
    }
    return far;
}

}  // namespace

Eigen::Matrix3f upright(const std::string& up) {
    const bool down = up.size() == 2 && up[0] == '-';
    const std::string axis = down ? up.substr(1) : up;
    if (axis != "x" && axis != "y" && axis != "z") throw BadCommandLine("--up " + up + ": give x, y, z, -x, -y or -z");
    const int k = axis[0] - 'x';
    Eigen::Matrix3f rows;
    rows << Vector3f::Unit((k + 1) % 3).transpose(), Vector3f::Unit((k + 2) % 3).transpose(),
        Vector3f::Unit(k).transpose();
    if (down) rows.row(0).swap(rows.row(1)), rows.row(2) *= -1.0F;
    return rows;
}

Camera::Camera(const ViewOptions& view, std::span<const Vector3f> points_m) : width_(view.width), height_(view.height) {
    const Eigen::AlignedBox3f box = box_of(points_m);
    const Eigen::Matrix3f rows = turn(view) * upright(view.up);
    std::vector<Vector3f> seen;
    for (const Vector3f& point : points_m) seen.push_back(rows * (point - box.center()));

    const float lens = std::tan(0.5F * kFieldDegrees * static_cast<float>(std::numbers::pi) / 180.0F);
    const Window free = window(view);
    const Eigen::Array2f room = lens * Eigen::Array2f(free.right - free.left, free.top - free.bottom);
    const float distance = fitting_distance(seen, room, box.diagonal().norm()) / static_cast<float>(view.zoom);
    const Eigen::Vector2f middle = spread(seen, distance).center() / lens;

    to_eye_.setIdentity();
    to_eye_.topLeftCorner<3, 3>() = rows;
    to_eye_.topRightCorner<3, 1>() = -(rows * box.center());
    to_eye_(2, 3) -= distance;

    const float aspect = static_cast<float>(view.width) / static_cast<float>(view.height);
    const float near = kNear * distance;
    const float far = kFar * distance;
    to_clip_.setZero();
    to_clip_(0, 0) = 1.0F / (lens * aspect);
    to_clip_(1, 1) = -1.0F / lens;  // down
    to_clip_(2, 2) = -(far + near) / (far - near);
    to_clip_(2, 3) = -2.0F * far * near / (far - near);
    to_clip_(3, 2) = -1.0F;
    // The points' middle goes to the middle of the free window.
    to_clip_(0, 2) = (middle.x() - 0.5F * (free.left + free.right)) / aspect;
    to_clip_(1, 2) = 0.5F * (free.top + free.bottom) - middle.y();
}

Eigen::Vector2f Camera::pixel(const Vector3f& point_m) const {
    const Vector4f clip = to_clip_ * to_eye_ * Vector4f(point_m.x(), point_m.y(), point_m.z(), 1.0F);
    return {0.5F * (clip.x() / clip.w() + 1.0F) * static_cast<float>(width_),
            0.5F * (clip.y() / clip.w() + 1.0F) * static_cast<float>(height_)};
}

float Camera::pixels_per_m(const Vector3f& point_m) const {
    const float ahead_m = -(to_eye_ * Vector4f(point_m.x(), point_m.y(), point_m.z(), 1.0F)).z();
    return 0.5F * static_cast<float>(height_) * std::abs(to_clip_(1, 1)) / std::max(ahead_m, 1e-9F);
}

}  // namespace haptable
