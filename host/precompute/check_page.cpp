// SPDX-License-Identifier: GPL-2.0-or-later
// Patches are filled from the farthest to the nearest (as host/view/figure.cpp does), on a canvas: a page that any
// browser shows, also without WebGL, and that can be printed.
#include "host/precompute/check_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "host/base/colors.hpp"
#include "host/base/index.hpp"
#include "host/base/json.hpp"

namespace haptable {

namespace {

using nlohmann::json;

constexpr const char* kHead = R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<style>
body { margin: 0; background: #fafaf8; font: 15px "DejaVu Sans", sans-serif; color: #28282e; overflow: hidden; }
canvas { display: block; width: 100vw; height: 100vh; touch-action: none; cursor: grab; }
#text { position: absolute; left: 20px; top: 14px; pointer-events: none; }
#text b { font-size: 19px; } #text div { color: #686870; margin-top: 4px; }
#legend { position: absolute; left: 20px; bottom: 14px; color: #686870; pointer-events: none; }
#legend i { display: inline-block; width: 12px; height: 12px; margin: 0 6px 0 18px; vertical-align: -1px; }
#legend i:first-child { margin-left: 0; }
</style>
)";

// Kinds of patches: 0 touchable, 1 held, 2 neither. Everything is drawn anew when something has changed.
constexpr const char* kScript = R"script(
const canvas = document.querySelector("canvas"), pen = canvas.getContext("2d");
const rgb = color => [1, 3, 5].map(i => parseInt(color.slice(i, i + 2), 16));
const colors = [data.colors.touchable, data.colors.held, data.colors.not_touchable].map(rgb);
const far_away = rgb(data.colors.far_from_scan);
const red = data.colors.worst_element, violet = data.colors.hinge, blue = data.colors.under_constrained;
const mid = [0, 1, 2].map(a => (data.box[a] + data.box[a + 3]) / 2);
const size = Math.hypot(...[0, 1, 2].map(a => data.box[a + 3] - data.box[a]));
let azimuth = -122, elevation = 24, zoom = 1, asked = false;

function rows() {
    const a = azimuth * Math.PI / 180, e = elevation * Math.PI / 180;
    const back = [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)];
    const right = [-Math.sin(a), Math.cos(a), 0];
    return [right, [back[1] * right[2] - back[2] * right[1], back[2] * right[0] - back[0] * right[2],
                    back[0] * right[1] - back[1] * right[0]], back];
}
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

function draw() {
    asked = false;
    const ratio = devicePixelRatio || 1, width = innerWidth, height = innerHeight;
    canvas.width = width * ratio, canvas.height = height * ratio;
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    const turn = rows(), far = 2.2 * size / zoom, scale = 0.85 * Math.min(width, height) * 2.2;
    const see = p => {
        const x = [p[0] - mid[0], p[1] - mid[1], p[2] - mid[2]], z = far - dot(turn[2], x);
        return [width / 2 + scale * dot(turn[0], x) / z, height / 2 + 14 - scale * dot(turn[1], x) / z, z];
    };
    const seen = data.point.map(see);
    const order = [];
    data.patch.forEach((p, k) => {
        const [a, b, c] = p.map(i => seen[i]);
        if (Math.min(a[2], b[2], c[2]) <= 0.02 * size) return;
        const area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if (area < 0) order.push([a[2] + b[2] + c[2], k]);  // y runs down: counter-clockwise from outside is negative
    });
    order.sort((a, b) => b[0] - a[0]);
    const lamp = [0.45 * turn[0][0] + 0.8 * turn[1][0] + 0.65 * turn[2][0],
                  0.45 * turn[0][1] + 0.8 * turn[1][1] + 0.65 * turn[2][1],
                  0.45 * turn[0][2] + 0.8 * turn[1][2] + 0.65 * turn[2][2]];
    pen.lineJoin = "round";
    box(see, true);
    for (const [, k] of order) {
        const p = data.patch[k], [a, b, c] = p.map(i => data.point[i]), u = [0, 1, 2].map(i => b[i] - a[i]);
        const v = [0, 1, 2].map(i => c[i] - a[i]);
        const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        const light = 0.62 + 0.34 * Math.max(0, dot(n, lamp) / (Math.hypot(...n) * 1.13 || 1));
        const away = data.away ? p.reduce((sum, i) => sum + data.away[i], 0) / 3 / data.farthest : 0;
        const color = colors[data.kind[k]].map((x, i) => Math.round(light * (x + away * (far_away[i] - x))));
        pen.fillStyle = "rgb(" + color.join() + ")";
        pen.strokeStyle = data.patch.length > 20000 ? pen.fillStyle : "rgba(40, 40, 46, 0.35)";
        pen.lineWidth = 0.6;
        path(p.map(i => seen[i]), true);
        pen.fill(), pen.stroke();
    }
    faults(see);
    box(see, false);
    axes(turn, width, height);
    scaleBar(scale / far, width, height);
}

function path(points, closed) {
    pen.beginPath();
    points.forEach((p, i) => i ? pen.lineTo(p[0], p[1]) : pen.moveTo(p[0], p[1]));
    if (closed) pen.closePath();
}
function word(text, x, y, color) {
    pen.font = "bold 13px DejaVu Sans, sans-serif", pen.lineWidth = 4;
    pen.strokeStyle = "rgba(250, 250, 248, 0.85)", pen.strokeText(text, x, y);
    pen.fillStyle = color, pen.fillText(text, x, y);
}
function faults(see) {
    for (const e of data.worst) {
        const p = e.at.map(see);
        pen.strokeStyle = red, pen.lineWidth = 2;
        for (let a = 0; a < 4; ++a)
            for (let b = 0; b < a; ++b) path([ p[a], p[b] ]), pen.stroke();
        word(e.number + ": " + e.ratio.toPrecision(2), p[0][0] + 7, p[0][1] - 5, red);
    }
    pen.strokeStyle = violet, pen.lineWidth = 3;
    for (const edge of data.hinge_edge) path(edge.map(see)), pen.stroke();
    const spots = (points, color, r) => {
        pen.fillStyle = color;
        for (const p of points.map(see)) pen.beginPath(), pen.arc(p[0], p[1], r, 0, 7), pen.fill();
    };
    spots(data.hinge_node, violet, 4), spots(data.loose, blue, 2.5);
}
function box(see, behind) {
    const corner = k => [ data.box[k & 1 ? 3 : 0], data.box[k & 2 ? 4 : 1], data.box[k & 4 ? 5 : 2] ];
    if (behind) {
        pen.strokeStyle = "rgba(104, 104, 112, 0.55)", pen.lineWidth = 1, pen.setLineDash([ 4, 4 ]);
        for (let k = 0; k < 8; ++k)
            for (const bit of [1, 2, 4])
                if (!(k & bit)) path([ corner(k), corner(k | bit) ].map(see)), pen.stroke();
        pen.setLineDash([]);
        return;
    }
    const tell = k => {
        const at = see(corner(k));
        word(corner(k).map(x => +x.toPrecision(4)).join(" ") + " m", at[0] + 8, at[1] + (k ? -8 : 16), "#686870");
    };
    tell(0), tell(7);
}
function axes(turn, width, height) {
    const x = width - 70, y = height - 90, ink = [ data.colors.axis_x, data.colors.axis_y, data.colors.axis_z ];
    [ 0, 1, 2 ].sort((a, b) => turn[2][a] - turn[2][b]).forEach(k => {
        pen.strokeStyle = ink[k], pen.lineWidth = 2.2;
        const d = [ 38 * turn[0][k], -38 * turn[1][k] ], far = Math.hypot(...d) > 5 ? 1 + 10 / Math.hypot(...d) : 0;
        path([[x, y], [x + d[0], y + d[1]]]), pen.stroke();
        word("xyz"[k], x - 4 + (far ? far * d[0] : -10), y + 5 + (far ? far * d[1] : -8), ink[k]);
    });
}
function scaleBar(px_per_m, width, height) {
    let step = 10 ** Math.floor(Math.log10(160 / px_per_m));
    for (const factor of [5, 2])
        if (step * factor * px_per_m <= 160) {
            step *= factor;
            break;
        }
    const right = width - 24, left = right - step * px_per_m, y = height - 26;
    pen.strokeStyle = "#28282e", pen.lineWidth = 1.6;
    path([[left, y - 4], [left, y + 4], [left, y], [right, y], [right, y - 4], [right, y + 4]]), pen.stroke();
    word(+(1e3 * step).toPrecision(3) + " mm", (left + right) / 2 - 22, y - 8, "#686870");
}
function again() {
    if (!asked) asked = true, requestAnimationFrame(draw);
}
addEventListener("resize", again);
canvas.addEventListener("pointermove", event => {
    if (!event.buttons) return;
    azimuth -= 0.4 * event.movementX, elevation = Math.max(-89, Math.min(89, elevation + 0.4 * event.movementY));
    again();
});
canvas.addEventListener("pointerdown", event => canvas.setPointerCapture(event.pointerId));
canvas.addEventListener("wheel", event => {
    zoom = Math.max(0.3, Math.min(12, zoom * Math.exp(-0.001 * event.deltaY)));
    again(), event.preventDefault();
}, { passive: false });
draw();
)script";

/// Text that neither HTML nor a script in it takes for its own.
std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text) out += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
    return out;
}

json point(const Body& body, std::int32_t node) {
    const Eigen::Vector3d& x = body.mesh.position_m[at(node)];
    // Six digits are a thousandth of a pixel.
    const auto shortened = [](double v) { return std::stod(fmt::format("{:.6g}", v)); };
    return {shortened(x.x()), shortened(x.y()), shortened(x.z())};
}

/// The largest of a scan's distances, m; 0 where nothing was wrapped.
double farthest_m(const Body& body) {
    const std::vector<double>& away_m = body.mesh.scan_distance_m;
    return away_m.empty() ? 0.0 : *std::max_element(away_m.begin(), away_m.end());
}

json points(const Body& body, const std::vector<std::int32_t>& nodes) {
    json list = json::array();
    for (const std::int32_t node : nodes) list.push_back(point(body, node));
    return list;
}

/// Nodes of the surface, renumbered; its patches and their kinds.
void add_surface(const Body& body, json& data) {
    std::vector<Patch> touchable = body.touch_patch;
    std::sort(touchable.begin(), touchable.end());
    std::vector<std::int32_t> place(body.mesh.position_m.size(), -1);
    for (std::size_t i = 0; i < body.surface.node.size(); ++i)
        place[at(body.surface.node[i])] = static_cast<std::int32_t>(i);
    data["point"] = points(body, body.surface.node);
    data["patch"] = data["kind"] = json::array();
    for (const Patch& patch : body.surface.patch) {
        const bool held = std::all_of(patch.begin(), patch.end(), [&](std::int32_t n) { return body.is_fixed(n); });
        const bool touched = std::binary_search(touchable.begin(), touchable.end(), patch);
        data["patch"].push_back({place[at(patch[0])], place[at(patch[1])], place[at(patch[2])]});
        data["kind"].push_back(held ? 1 : touched ? 0 : 2);
    }
}

json data_of(const Body& body, const Audit& audit, const std::vector<std::int32_t>& under_constrained) {
    const Eigen::Vector3d &low = audit.box_m.min(), &high = audit.box_m.max();
    json data{{"box", {low.x(), low.y(), low.z(), high.x(), high.y(), high.z()}},
              {"loose", points(body, under_constrained)},
              {"hinge_node", points(body, audit.hinge_node)},
              {"hinge_edge", json::array()},
              {"worst", json::array()}};
    add_surface(body, data);
    if (farthest_m(body) > 0.0) {
        data["farthest"] = farthest_m(body);
        for (const std::int32_t node : body.surface.node) data["away"].push_back(body.mesh.scan_distance_m[at(node)]);
    }
    for (const DrawnColor& color : kDrawnColors)
        data["colors"][std::string(color.name)] = fmt::format("#{:06x}", color.on_light);
    for (const auto& [a, b] : audit.hinge_edge) data["hinge_edge"].push_back({point(body, a), point(body, b)});
    for (const ShapedTet& tet : audit.worst)
        data["worst"].push_back(
            {{"number", tet.number}, {"ratio", tet.ratio}, {"at", points(body, {tet.node.begin(), tet.node.end()})}});
    return data;
}

}  // namespace

std::string check_page(const Scene& scene, const Body& body, const Audit& audit,
                       const std::vector<std::int32_t>& under_constrained) {
    const Eigen::Vector3d &low = audit.box_m.min(), &high = audit.box_m.max();
    const auto sign = [](const Rgb8& color, const std::string& text) {
        return fmt::format("<i style=\"background: {}\"></i>{}", css(color), text);
    };
    std::string legend = sign(drawn_color("touchable"), "touchable") +
                         sign(drawn_color("held"), fmt::format("held ({} nodes)", body.fixed_count())) +
                         sign(drawn_color("not_touchable"), "neither") +
                         sign(drawn_color("worst_element"), "worst elements (number: radius ratio)");
    if (audit.hinge_edges + audit.hinge_nodes > 0) legend += sign(drawn_color("hinge"), "hinges");
    if (farthest_m(body) > 0.0)
        legend += sign(drawn_color("far_from_scan"),
                       fmt::format("far from the scan (at most {:.3g} mm)", 1e3 * farthest_m(body)));
    if (!under_constrained.empty())
        legend += sign(drawn_color("under_constrained"),
                       fmt::format("under-constrained ({} nodes)", under_constrained.size()));
    return fmt::format(
        "{}<title>{}</title></head>\n<body><canvas></canvas>\n<div id=\"text\"><b>{}</b>\n"
        "<div>{} nodes, {} tetrahedra, {} patches; radius ratio: worst {:.2g}, median {:.2f}; volume {:.4g} m^3</div>\n"
        "<div>x {:.4g} to {:.4g}, y {:.4g} to {:.4g}, z {:.4g} to {:.4g} m</div></div>\n"
        "<div id=\"legend\">{}</div>\n<script>\"use strict\";\nconst data = {};\n{}</script></body></html>\n",
        kHead, escaped(scene.name), escaped(scene.name), audit.nodes, audit.tets, audit.patches, audit.worst_ratio,
        audit.median_ratio, audit.volume_m3, low.x(), high.x(), low.y(), high.y(), low.z(), high.z(), legend,
        json_text(data_of(body, audit, under_constrained)), kScript);
}

}  // namespace haptable
