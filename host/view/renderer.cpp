// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/renderer.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host/base/turn.hpp"
#include "host/view/colormap.hpp"
#include "host/view/shaders.hpp"
#include "host/view/shapes.hpp"

namespace haptable {

namespace {

using Eigen::Matrix4f;
using Eigen::Vector3f;

constexpr float kHiddenOpacity = 0.6F;  // of what lies behind the surface
// Shares of the body's size.
constexpr float kShaft = 0.0055F;
constexpr float kHead = 0.0155F;
constexpr float kHeadLength = 0.042F;
constexpr float kRod = 0.0028F;
constexpr float kRoomTop = 0.20F;  // above the rest shape, for an arrow

Vector3f share(const Rgb8& color) { return Vector3f(color[0], color[1], color[2]) / 255.0F; }

std::vector<Vector3f> turned_points(const std::vector<Vector3f>& points, const Eigen::Matrix3f& turn) {
    std::vector<Vector3f> out;
    for (const Vector3f& p : points) out.emplace_back(turn * p);
    return out;
}

Vector3f lowest(const std::vector<Vector3f>& points) {
    Vector3f low = Vector3f::Constant(std::numeric_limits<float>::max());
    for (const Vector3f& p : points) low = low.cwiseMin(p);
    return low;
}

Vector3f highest(const std::vector<Vector3f>& points) {
    Vector3f high = Vector3f::Constant(std::numeric_limits<float>::lowest());
    for (const Vector3f& p : points) high = high.cwiseMax(p);
    return high;
}

/// The diagonal of a cube of the same volume, but of a sheet or a stick not less than a share of its own diagonal.
float size_of(const Vector3f& box) {
    constexpr float kLeast = 0.4F;
    return std::max(std::sqrt(3.0F) * std::cbrt(box.prod()), kLeast * box.norm());
}

/// What has to be in the picture: the rest shape, and room above its upper half for the arrow.
std::vector<Vector3f> framed(const DrawnSurface& surface, const std::vector<Vector3f>& upright_m, const Vector3f& up,
                             float size_m) {
    std::vector<Vector3f> points = surface.rest_m;
    const float middle = 0.5F * (lowest(upright_m).z() + highest(upright_m).z());
    for (std::size_t i = 0; i < upright_m.size(); ++i)
        if (upright_m[i].z() > middle) points.emplace_back(surface.rest_m[i] + kRoomTop * size_m * up);
    return points;
}

/// The z axis of a unit shape laid from `from` to `to`.
Matrix4f along(const Vector3f& from, const Vector3f& to, float radius) {
    const Vector3f axis = to - from;
    Matrix4f place = Matrix4f::Identity();
    place.topLeftCorner<3, 3>() =
        turn_from_z(axis).toRotationMatrix() * Vector3f(radius, radius, axis.norm()).asDiagonal();
    place.topRightCorner<3, 1>() = from;
    return place;
}

Matrix4f ball(const Vector3f& centre, float radius) {
    Matrix4f place = Matrix4f::Identity();
    place.topLeftCorner<3, 3>() *= radius;
    place.topRightCorner<3, 1>() = centre;
    return place;
}

constexpr std::size_t kCornerFloats = 11;  // of the surface

/// Counted from 1 in the shader.
constexpr std::array<Rgb8, 3> kPlainColors{kNeutralColor, kHeldColor, kTouchableColor};

GLuint make_texture(GLint format, int width, int height, GLenum layout, const void* texels) {
    GLuint texture = 0;
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_2D, texture);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTexImage2D(GL_TEXTURE_2D, 0, format, width, height, 0, layout, GL_UNSIGNED_BYTE, texels);
    for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
        glTexParameteri(GL_TEXTURE_2D, filter, GL_LINEAR);
    for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
        glTexParameteri(GL_TEXTURE_2D, wrap, GL_CLAMP_TO_EDGE);
    return texture;
}

std::string lit(const char* fragment) { return fmt::format("{}{}{}", kVersionLine, kLight, fragment); }
std::string plain(const char* source) { return std::string(kVersionLine) + source; }

}  // namespace

int plain_color(const DrawnSurface& surface, std::size_t patch, bool colored) {
    if (surface.held[patch] != 0) return 2;
    if (surface.touchable[patch] == 0) return 1;
    return colored ? 0 : 3;
}

const Rgb8& plain_color(int number) { return kPlainColors.at(static_cast<std::size_t>(number - 1)); }

Renderer::Renderer(const ViewOptions& view, const DrawnSurface& surface)
    : upright_(upright(view.up)),
      upright_m_(turned_points(surface.rest_m, upright_)),
      low_m_(lowest(upright_m_)),
      high_m_(highest(upright_m_)),
      size_m_(size_of(high_m_ - low_m_)),
      camera_(view, framed(surface, upright_m_, upright_.row(2), size_m_)),
      line_px_(1.1F / 720.0F * reference_px(view.width, view.height)),
      target_(view.width, view.height, view.samples),
      surface_program_(make_program(plain(kSurfaceVertex), lit(kSurfaceFragment))),
      solid_program_(make_program(plain(kSolidVertex), lit(kSolidFragment))),
      surface_({3, 3, 2, 3}),
      sphere_({3, 3}),
      rod_({3, 3}),
      cone_({3, 3}),
      ghost_({3, 3}),
      tool_({3, 3}),
      has_ghost_(view.ghost),
      smooths_(view.samples == 1) {
    sphere_.upload(sphere_shape(), GL_STATIC_DRAW);
    rod_.upload(rod_shape(), GL_STATIC_DRAW);
    cone_.upload(cone_shape(), GL_STATIC_DRAW);
    map_ = make_texture(GL_RGB8, static_cast<int>(kColors), 1, GL_RGB, color_map().data());
    if (has_ghost_) upload_ghost(surface);
    bake_background(surface, view);
}

/// The ground is the same in every picture: it is drawn once. From below it is not seen.
void Renderer::bake_background(const DrawnSurface& surface, const ViewOptions& view) {
    const Shadow shadow = cast_shadow(surface, upright_m_, low_m_, high_m_);
    std::vector<float> corners;
    constexpr float kQuad[6][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
    for (const auto& [u, v] : kQuad) {
        const Vector3f at = upright_.transpose() * Vector3f(shadow.low_x_m + u * shadow.side_m,
                                                            shadow.low_y_m + v * shadow.side_m, low_m_.z());
        corners.insert(corners.end(), {at.x(), at.y(), at.z(), u, v});
    }
    Triangles ground({3, 2});
    ground.upload(corners, GL_STATIC_DRAW);
    const GLuint program = make_program(plain(kGroundVertex), plain(kGroundFragment));
    make_texture(GL_R8, Shadow::kCells, Shadow::kCells, GL_RED, shadow.darkness.data());

    background_.width = view.width;
    background_.height = view.height;
    const Rgb8& c = kBackgroundColor;
    background_.pixel.assign(static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height),
                             static_cast<std::uint32_t>(c[0] << 16U | c[1] << 8U | c[2]));
    PixelBox all;
    all.include(Eigen::Vector2f::Zero(), static_cast<float>(view.width + view.height));
    target_.begin(all);
    glFrontFace(GL_CW);
    glEnable(GL_CULL_FACE);
    glUseProgram(program);
    set_uniform(program, "to_eye", camera_.to_eye());
    set_uniform(program, "to_clip", camera_.to_clip());
    ground.draw();
    target_.read_over(background_);
}

/// In the body's own axes, with the rest shape's normals.
void Renderer::upload_ghost(const DrawnSurface& surface) {
    std::vector<float> corners;
    for (std::size_t p = 0; p < surface.patches(); ++p)
        for (int c = 0; c < 3; ++c) {
            const Vector3f& at = surface.rest_m[static_cast<std::size_t>(surface.patch[p][c])];
            const Vector3f& n = surface.normal[static_cast<std::size_t>(surface.normal_of[p][c])];
            corners.insert(corners.end(), {at.x(), at.y(), at.z(), n.x(), n.y(), n.z()});
        }
    ghost_.upload(corners, GL_STATIC_DRAW);
}

void Renderer::upload_surface(const DrawnSurface& surface, const Shading& shading) {
    const bool colored = !shading.value.empty() && shading.range > 0.0F;
    const float per_range = colored ? 1.0F / shading.range : 0.0F;
    corners_.resize(surface.patches() * 3 * kCornerFloats);
    float* to = corners_.data();
    for (std::size_t p = 0; p < surface.patches(); ++p) {
        const float plain = static_cast<float>(plain_color(surface, p, colored));
        const auto& crease = surface.crease[p];
        for (int c = 0; c < 3; ++c, to += kCornerFloats) {
            const auto node = static_cast<std::size_t>(surface.patch[p][c]);
            const Vector3f at = surface.rest_m[node] + surface.displacement_m[node];
            const Vector3f& n = surface.normal[static_cast<std::size_t>(surface.normal_of[p][c])];
            const float share = colored ? shading.value[node] * per_range : 0.0F;
            const float corner[kCornerFloats] = {at.x(),
                                                 at.y(),
                                                 at.z(),
                                                 n.x(),
                                                 n.y(),
                                                 n.z(),
                                                 share,
                                                 plain,
                                                 static_cast<float>(crease[0]),
                                                 static_cast<float>(crease[1]),
                                                 static_cast<float>(crease[2])};
            std::copy_n(corner, kCornerFloats, to);
        }
    }
    surface_.upload(corners_, GL_STREAM_DRAW);
}

void Renderer::draw(const DrawnSurface& surface, const Markers& markers, const Shading& shading, Image& image) {
    image = background_;
    const PixelBox box = bounds(surface, markers);
    target_.begin(box);
    glFrontFace(GL_CW);  // counter-clockwise from outside, but the picture's y runs down
    upload_surface(surface, shading);
    draw_surface(surface.is_inside_out);
    if (has_ghost_) draw_ghost();
    draw_markers(markers, 1.0F);
    // Once more what lies behind the surface, half transparent: the finger is inside the rest shape.
    glDepthFunc(GL_GREATER);
    glDepthMask(GL_FALSE);
    draw_markers(markers, kHiddenOpacity);
    target_.read_over(image);
    if (smooths_) smooth_.run(image, box);
}

/// The part of the picture in which anything is drawn.
PixelBox Renderer::bounds(const DrawnSurface& surface, const Markers& markers) const {
    PixelBox box;
    const auto include = [&](const Vector3f& point, float radius_m) {
        box.include(camera_.pixel(point), camera_.pixels_per_m(point) * radius_m + 2.0F);
    };
    for (std::size_t i = 0; i < surface.nodes(); ++i) {
        include(surface.rest_m[i] + surface.displacement_m[i], 0.0F);
        if (has_ghost_) include(surface.rest_m[i], 0.0F);
    }
    for (const auto& marker : {markers.finger, markers.god_object, markers.arrow_tip})
        if (marker) include(*marker, kSphereShare * size_m_);
    for (const Vector3f& corner : tool_m_)
        if (markers.tool) include((*markers.tool * corner.homogeneous()).head<3>(), 0.0F);
    for (const Vector3f& at : markers.touching) include(at, kSphereShare * size_m_);
    for (const Markers& other : markers.others)
        for (const auto& marker : {other.finger, other.god_object, other.arrow_tip})
            if (marker) include(*marker, kSphereShare * size_m_);
    return box;
}

void Renderer::draw_surface(bool inside_too) {
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glDisable(GL_BLEND);
    glEnable(GL_CULL_FACE);
    glUseProgram(surface_program_);
    set_uniform(surface_program_, "to_eye", camera_.to_eye());
    set_uniform(surface_program_, "to_clip", camera_.to_clip());
    set_uniform(surface_program_, "line_px", line_px_);
    for (std::size_t k = 0; k < kPlainColors.size(); ++k)
        set_uniform(surface_program_, fmt::format("plain[{}]", k).c_str(), share(kPlainColors[k]));
    glBindTexture(GL_TEXTURE_2D, map_);
    surface_.draw();
    // Where a large force has turned the linear model inside out, its inside shows. Elsewhere it is hidden, and would
    // cost as much as the outside: the rasterizer shades a pixel before it finds it hidden.
    if (!inside_too) return;
    glCullFace(GL_FRONT);
    surface_.draw();
    glCullFace(GL_BACK);
}

/// Over the surface as it is: where it has been pressed in, the rest shape is before it.
void Renderer::draw_ghost() {
    constexpr float kOpacity = 0.28F;
    glEnable(GL_BLEND);
    glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(1.0F, 4.0F);  // where nothing moved, the surface itself wins
    glDepthMask(GL_FALSE);
    glUseProgram(solid_program_);
    set_uniform(solid_program_, "to_eye", camera_.to_eye());
    set_uniform(solid_program_, "to_clip", camera_.to_clip());
    draw_solid(ghost_, Matrix4f::Identity(), share(kNeutralColor), kOpacity);
    glDisable(GL_POLYGON_OFFSET_FILL);
    glDepthMask(GL_TRUE);
}

void Renderer::set_tool(std::span<const std::array<float, 3>> corner_m) {
    std::vector<float> vertices;
    for (const std::array<float, 3>& corner : corner_m) tool_m_.emplace_back(corner.data());
    for (std::size_t i = 0; i + 2 < tool_m_.size(); i += 3) {
        const Vector3f normal = (tool_m_[i + 1] - tool_m_[i]).cross(tool_m_[i + 2] - tool_m_[i]).normalized();
        for (std::size_t c = i; c < i + 3; ++c)
            for (const Vector3f& v : {tool_m_[c], normal}) vertices.insert(vertices.end(), {v.x(), v.y(), v.z()});
    }
    tool_.upload(vertices, GL_STATIC_DRAW);
}

/// Half transparent, so that the dent below it is seen, with a mark at each point that touches.
void Renderer::draw_tool(const Markers& markers, float opacity) {
    constexpr float kOpacity = 0.55F, kTouching = 0.5F;
    for (const Vector3f& at : markers.touching)
        draw_solid(sphere_, ball(at, kTouching * kSphereShare * size_m_), share(kGodObjectColor), opacity);
    if (markers.tool && !tool_m_.empty()) draw_solid(tool_, *markers.tool, share(kFingerColor[0]), kOpacity * opacity);
}

void Renderer::draw_markers(const Markers& markers, float opacity, std::size_t number) {
    for (const Markers& other : markers.others) draw_markers(other, opacity, number + 1);
    glEnable(GL_CULL_FACE);
    glEnable(GL_BLEND);
    glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    glUseProgram(solid_program_);
    set_uniform(solid_program_, "to_eye", camera_.to_eye());
    set_uniform(solid_program_, "to_clip", camera_.to_clip());
    const float radius = kSphereShare * size_m_;
    if (markers.tool) draw_tool(markers, opacity);
    if (markers.god_object && markers.finger && (*markers.god_object - *markers.finger).norm() > radius)
        draw_solid(rod_, along(*markers.god_object, *markers.finger, kRod * size_m_), share(kArrowColor), opacity);
    if (markers.finger) draw_solid(sphere_, ball(*markers.finger, radius), share(kFingerColor.at(number)), opacity);
    if (!markers.god_object) return;
    draw_solid(sphere_, ball(*markers.god_object, radius), share(kGodObjectColor), opacity);
    if (!markers.arrow_tip) return;
    const Vector3f from = *markers.god_object;
    const float length = (*markers.arrow_tip - from).norm();
    if (length < radius) return;  // it would stay inside the sphere
    const float head = std::min(kHeadLength * size_m_, 0.5F * length);
    const Vector3f neck = *markers.arrow_tip - head / length * (*markers.arrow_tip - from);
    draw_solid(rod_, along(from, neck, kShaft * size_m_), share(kArrowColor), opacity);
    draw_solid(cone_, along(neck, *markers.arrow_tip, kHead * size_m_), share(kArrowColor), opacity);
}

void Renderer::draw_solid(const Triangles& shape, const Matrix4f& place, const Vector3f& color, float opacity) {
    set_uniform(solid_program_, "place", place);
    set_uniform(solid_program_, "tint", Eigen::Vector4f(color.x(), color.y(), color.z(), opacity));
    shape.draw();
}

}  // namespace haptable
