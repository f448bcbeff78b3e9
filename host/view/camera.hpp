// SPDX-License-Identifier: GPL-2.0-or-later
// Where the body is seen from, and where a point of it lands in the picture.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <span>
#include <string>

namespace haptable {

/// How the picture is taken. Angles in degrees: azimuth of the eye from +x towards +y, elevation above the xy plane
/// (where another axis points up, of the two that follow it: from +z towards +x for y).
struct ViewOptions {
    int width = 960;
    int height = 720;
    double azimuth = -122.0;
    double elevation = 24.0;
    double zoom = 1.0;
    int samples = 4;  ///< a pixel: 4, or 1 with outlines smoothed afterwards (antialias.hpp), for 3 times the speed
    std::string up = "z";                ///< the body's axis that points up in the picture: x y z -x -y -z
    bool ghost = false;                  ///< the rest shape too, half transparent
    std::string color = "displacement";  ///< what the colours show: displacement, force (of the nodes) or stress
    double exaggeration = 1.0;           ///< of what is drawn of the displacements
    double speed = 0.0;                  ///< of a film: seconds of the session in a second; 0: no film
};

/// Rows: the body's directions that the picture takes for x, y and up; a rotation. Throws Error for another word.
Eigen::Matrix3f upright(const std::string& up);

/// A perspective camera, z up, that stands so far off that some points just fit the part of the picture that title,
/// legend and scale bar leave free, in its middle.
class Camera {
public:
    /// `points_m`: one or more.
    Camera(const ViewOptions& view, std::span<const Eigen::Vector3f> points_m);

    /// Metres to eye space: x right, y up, -z ahead; metres.
    const Eigen::Matrix4f& to_eye() const { return to_eye_; }
    /// Eye space to clip space, with rows of the picture counted from the top (y down).
    const Eigen::Matrix4f& to_clip() const { return to_clip_; }
    /// Where a point lands, in pixels from the top left corner of the picture.
    Eigen::Vector2f pixel(const Eigen::Vector3f& point_m) const;
    /// How large a metre across the line of sight is at a point.
    float pixels_per_m(const Eigen::Vector3f& point_m) const;

private:
    int width_;
    int height_;
    Eigen::Matrix4f to_eye_;
    Eigen::Matrix4f to_clip_;
};

/// What text, lines and margins are sized by: the height of a picture of 4:3, but of a narrow one its width counts.
inline float reference_px(int width, int height) {
    return std::min(static_cast<float>(height), 0.75F * static_cast<float>(width));
}

/// The margins that title (top), legend (bottom) and scale bar (right) take, as shares of reference_px.
inline constexpr float kTopMargin = 0.09F;
inline constexpr float kBottomMargin = 0.08F;
inline constexpr float kSideMargin = 0.05F;
inline constexpr float kBarMargin = 0.175F;

}  // namespace haptable
