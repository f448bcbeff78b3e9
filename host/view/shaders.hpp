// SPDX-License-Identifier: GPL-2.0-or-later
// The programs that run once a vertex and once a pixel. Light is the square of a stored colour, and the colour its
// root: near enough to sRGB's exponent of 2.2, and a tenth of the time of a power on a processor.
#pragma once

namespace haptable {

inline constexpr const char* kVersionLine = "#version 330 core\n";

/// One lamp at the upper left behind the viewer, a weak one at the right, and a sky: eye space.
inline constexpr const char* kLight = R"(
const vec3 key = normalize(vec3(-0.45, 0.80, 0.65));
const vec3 fill = normalize(vec3(0.85, 0.05, 0.50));

vec3 light(vec3 base, vec3 normal, vec3 to_eye, float gloss) {
    float sky = 0.5 + 0.5 * normal.y;
    float diffuse = 0.36 + 0.20 * sky + 0.46 * max(dot(normal, key), 0.0) + 0.24 * max(dot(normal, fill), 0.0);
    float shine = max(dot(normal, normalize(key + to_eye)), 0.0);
    shine *= shine, shine *= shine, shine *= shine, shine *= shine, shine *= shine;  // to the 32nd
    return base * diffuse + gloss * shine;
}
)";

/// Every triangle has corners of its own, so that a corner's number tells its area coordinates.
inline constexpr const char* kSurfaceVertex = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 look;  // share of the colour range; 0 for a colour of the map, else one of the plain ones
layout(location = 3) in vec3 wide;  // the edge opposite to each corner is a crease
uniform mat4 to_eye, to_clip;
out vec3 eye, eye_normal, area, crease;
out vec2 look_at;

void main() {
    vec4 seen = to_eye * vec4(position, 1.0);
    eye = seen.xyz;
    eye_normal = mat3(to_eye) * normal;
    look_at = look;
    crease = wide;
    int corner = gl_VertexID % 3;
    area = vec3(corner == 0, corner == 1, corner == 2);
    gl_Position = to_clip * seen;
}
)";

/// An area coordinate over its gradient is the distance to the edge in pixels: lines are as wide everywhere, they lie
/// in the surface, and need no second pass that could fight with it for depth. They fade where triangles get tiny.
inline constexpr const char* kSurfaceFragment = R"(
in vec3 eye, eye_normal, area, crease;
in vec2 look_at;
uniform sampler2D map;
uniform vec3 plain[3];
uniform float line_px;
out vec4 color;

void main() {
    vec3 normal = normalize(gl_FrontFacing ? eye_normal : -eye_normal);
    float t = clamp(look_at.x, 0.0, 1.0) * (255.0 / 256.0) + 0.5 / 256.0;
    vec3 base = look_at.y < 0.5 ? texture(map, vec2(t, 0.5)).rgb : plain[clamp(int(look_at.y - 0.5), 0, 2)];
    vec3 lit = sqrt(light(base * base, normal, normalize(-eye), 0.05));

    vec3 dx = dFdx(area), dy = dFdy(area);
    vec3 height_px = inversesqrt(dx * dx + dy * dy);
    vec3 half_px = 0.5 * line_px * (1.0 + 0.9 * step(0.5, crease));
    vec3 line = clamp(half_px + 0.5 - area * height_px, 0.0, 1.0) * (0.6 + 0.3 * step(0.5, crease));
    float strongest = max(line.x, max(line.y, line.z));
    float fade = smoothstep(1.5, 8.0, min(height_px.x, min(height_px.y, height_px.z)));
    color = vec4(mix(lit, vec3(0.09, 0.09, 0.13), strongest * fade), 1.0);
}
)";

/// Spheres, arrow, rod: a unit shape, placed.
inline constexpr const char* kSolidVertex = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 place, to_eye, to_clip;
out vec3 eye, eye_normal;

void main() {
    vec4 seen = to_eye * place * vec4(position, 1.0);
    eye = seen.xyz;
    eye_normal = mat3(to_eye) * transpose(inverse(mat3(place))) * normal;
    gl_Position = to_clip * seen;
}
)";

inline constexpr const char* kSolidFragment = R"(
in vec3 eye, eye_normal;
uniform vec4 tint;  // with opacity
out vec4 color;

void main() {
    color = vec4(sqrt(light(tint.rgb * tint.rgb, normalize(eye_normal), normalize(-eye), 0.2)), tint.a);
}
)";

/// The ground under the body: nothing but the body's soft shadow.
inline constexpr const char* kGroundVertex = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec2 at;
uniform mat4 to_eye, to_clip;
out vec2 uv;

void main() {
    uv = at;
    gl_Position = to_clip * to_eye * vec4(position, 1.0);
}
)";

inline constexpr const char* kGroundFragment = R"(
in vec2 uv;
uniform sampler2D shadow;
out vec4 color;  // multiplied by its opacity

void main() {
    float dark = texture(shadow, uv).r;
    color = vec4(dark * vec3(0.10, 0.11, 0.15), dark);
}
)";

}  // namespace haptable
