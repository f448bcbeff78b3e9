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

constexpr const char* kHead =
#include "host/precompute/check_page.html.in"
    ;

// Kinds of patches: 0 touchable, 1 held, 2 neither. Everything is drawn anew when something has changed.
constexpr const char* kScript =
#include "host/precompute/check_page.js.in"
    ;

/// Text that neither HTML nor a script in it takes for its own.
std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text) out += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
    return out;
}

nlohmann::json point(const Body& body, std::int32_t node) {
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

nlohmann::json points(const Body& body, const std::vector<std::int32_t>& nodes) {
    nlohmann::json list = nlohmann::json::array();
    for (const std::int32_t node : nodes) list.push_back(point(body, node));
    return list;
}

/// Nodes of the surface, renumbered; its patches and their kinds.
void add_surface(const Body& body, nlohmann::json& data) {
    std::vector<Patch> touchable = body.touch_patch;
    std::sort(touchable.begin(), touchable.end());
    std::vector<std::int32_t> place(body.mesh.position_m.size(), -1);
    for (std::size_t i = 0; i < body.surface.node.size(); ++i)
        place[at(body.surface.node[i])] = static_cast<std::int32_t>(i);
    data["point"] = points(body, body.surface.node);
    data["patch"] = data["kind"] = nlohmann::json::array();
    for (const Patch& patch : body.surface.patch) {
        const bool held = std::all_of(patch.begin(), patch.end(), [&](std::int32_t n) { return body.is_fixed(n); });
        const bool touched = std::binary_search(touchable.begin(), touchable.end(), patch);
        data["patch"].push_back({place[at(patch[0])], place[at(patch[1])], place[at(patch[2])]});
        data["kind"].push_back(held ? 1 : touched ? 0 : 2);
    }
}

nlohmann::json data_of(const Body& body, const Audit& audit, const std::vector<std::int32_t>& under_constrained) {
    const Eigen::Vector3d &low = audit.box_m.min(), &high = audit.box_m.max();
    nlohmann::json data{{"box", {low.x(), low.y(), low.z(), high.x(), high.y(), high.z()}},
                        {"loose", points(body, under_constrained)},
                        {"hinge_node", points(body, audit.hinge_node)},
                        {"hinge_edge", nlohmann::json::array()},
                        {"worst", nlohmann::json::array()}};
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
