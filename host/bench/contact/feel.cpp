// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/bench/contact/feel.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>
#include <random>

#include "host/base/error.hpp"
#include "host/bench/contact/bodies.hpp"

namespace haptable {

namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

// ---- closed loops --------------------------------------------------------------------------------------------------

struct Loop {
    Vector3d above, in, across, out;  // m
};

/// From outside of a random patch 0.9 to 3 mm deep, 1.8 to 6 mm along under it, out.
Loop random_loop(const Tables& tables, std::mt19937& random) {
    std::uniform_real_distribution<double> uniform(0.3, 1.0);
    std::uniform_int_distribution<std::size_t> any(0, tables.patch.size() - 1);
    std::array<Vector3d, 3> v;
    const auto& patch = tables.patch[any(random)];
    for (std::size_t c = 0; c < 3; ++c) v[c] = Vector3d(tables.position[static_cast<std::size_t>(patch[c])].data());
    const Vector3d alpha(uniform(random), uniform(random), uniform(random));
    const Vector3d start = (alpha[0] * v[0] + alpha[1] * v[1] + alpha[2] * v[2]) / alpha.sum();
    const Vector3d n = (v[1] - v[0]).cross(v[2] - v[0]).normalized(), side = n.unitOrthogonal();
    const double angle = 2.0 * std::numbers::pi * uniform(random);
    const Vector3d along = std::cos(angle) * side + std::sin(angle) * n.cross(side);
    const double depth = 0.003 * uniform(random), width = 0.006 * uniform(random);
    const Vector3d in = start - depth * n, across = in + width * along;
    return {start + 0.001 * n, in, across, across + (depth + 0.02) * n};
}

/// Given over the most that was stored; 0 where nothing was touched.
double given_by(BenchFinger& finger, const Loop& loop) {
    double given = 0.0, stored = 0.0;  // J
    finger.begin();
    Vector3d force = finger.to(loop.above), at = finger.at();
    const auto go = [&](const Vector3d& from, const Vector3d& to) {
        const int steps = std::max(1, static_cast<int>((to - from).norm() / 1e-5));
        for (int i = 1; i <= steps; ++i) {
            const Vector3d next = finger.to(from + (to - from) * i / steps);
            given += 0.5 * (next + force).dot(finger.at() - at);
            at = finger.at();
            force = next;
            stored = std::max(stored, finger.energy());
        }
    };
    go(loop.above, loop.in);
    go(loop.in, loop.across);
    go(loop.across, loop.out);
    go(loop.out, loop.above);
    return stored > 0.0 ? given / stored : 0.0;
}

double worst_loop(const Subject& subject, int loops) {
    BenchFinger finger(bare(subject.model()));
    std::mt19937 random(11);
    double worst = 0.0;
    for (int i = 0; i < loops; ++i) worst = std::max(worst, given_by(finger, random_loop(subject.tables(), random)));
    return worst;
}

// ---- slides over the cube's top ------------------------------------------------------------------------------------

/// A straight slide of 18 ms at 100 mm/s, or of another speed over the same way.
struct Line {
    Vector3d begin{0.006, 0.011, 0.03};  // m, on the surface
    Vector3d along{0.1, 0.03, 0.0};      // m/s
    double depth_m = 0.001;
    int ticks = 180;
    int ticks_per_ms = 1;
};

struct Slide {
    std::vector<Vector3d> force;  // N, one a tick
    double n_per_m = 0.0;         // mean normal stiffness
};

Slide slide(const haptable_model& model, const Line& line) {
    BenchFinger finger(model);
    const Vector3d deep = line.begin - Vector3d(0, 0, line.depth_m);
    for (int i = 100; i >= 0; --i) finger.to(deep + Vector3d(0, 0, line.depth_m * i / 99.0));
    Slide result;
    for (int i = 0; i <= line.ticks; ++i) {
        result.force.push_back(finger.to(deep + 1e-3 / line.ticks_per_ms * i * line.along));
        if (!finger.touches()) throw Error("the bench's finger lost contact: nothing was measured");
        result.n_per_m += result.force.back().z() / line.depth_m / (line.ticks + 1);
    }
    return result;
}

/// Largest change from one tick to the next, N; `tangential`: of its part along the surface.
double largest_change(const Slide& slide, bool tangential) {
    double largest = 0.0;
    for (std::size_t i = 1; i < slide.force.size(); ++i) {
        const Vector3d change = slide.force[i] - slide.force[i - 1];
        largest = std::max(largest, tangential ? change.head<2>().norm() : change.norm());
    }
    return largest;
}

/// The cube under a mode, a mask with a radius of two edges.
std::unique_ptr<Subject> cube(int nodes, const ContactMode& mode, const fs::path& build) {
    return touched_as(contact_cube(nodes, 0.3), mode, 2.0 * 0.03 / (nodes - 1), build);
}

std::string short_name(const ContactMode& mode) {
    const bool least = mode.god_object == GodObject::kLeastEnergy;
    return fmt::format("{}, {}", word(mode.force), least ? "least energy" : "nearest");
}

Number millinewtons(double n) { return number(n, fmt::format("{:.{}f} mN", 1e3 * n, n < 0.00995 ? 1 : 0)); }

}  // namespace

NumberTable stiffness_table(const StiffnessLine& line) {
    NumberTable table{{"nodes a side", "interpolated", "consistent", "mask of 5 mm"}, {}};
    for (std::size_t m = 0; m < line.nodes_per_side.size(); ++m) {
        table.rows.push_back({fmt::format("{}", line.nodes_per_side[m])});
        for (std::size_t f = 0; f < 3; ++f) {
            const auto& k = line.n_per_m[3 * m + f];
            double mean = 0.0;
            for (double one : k) mean += one / static_cast<double>(k.size());
            const auto [least, most] = std::minmax_element(k.begin(), k.end());
            const double ripple = (*most - *least) / mean;
            table.rows.back().push_back(
                Number{{mean, ripple}, fmt::format("{:.1f} N/m, {:.2g} %", mean, 100 * ripple)});
        }
    }
    return table;
}

NumberTable loop_table(const fs::path& build, int loops) {
    NumberTable table{{"", "interpolated", "consistent", "pressure mask"}, {}};
    struct Body {
        const char* name;
        Scene scene;
        double mask_radius_m;
    };
    const Body bodies[] = {{"cube, nu = 0.3", contact_cube(5, 0.3), 0.008},
                           {"cube, nu = 0.49", contact_cube(5, 0.49), 0.008},
                           {"mouse", read_scene("meshes/mouse.toml"), 0.006}};
    for (const Body& body : bodies)
        for (std::size_t god_object : {1U, 0U}) {
            const auto* mode = &kContactModes[3 * god_object];
            table.rows.push_back({fmt::format("{}, {}", body.name, god_object == 1U ? "least energy" : "nearest")});
            for (int f = 0; f < 3; ++f) {
                const double worst =
                    worst_loop(*touched_as(body.scene, mode[f], body.mask_radius_m, build / "loops"), loops);
                table.rows.back().push_back(worst < 0.01 ? number(worst, fmt::format("{:.0e}", worst))
                                                         : number(worst, fmt::format("{:.1f}", worst)));
            }
        }
    return table;
}

NumberTable change_table(const fs::path& build) {
    NumberTable table{{"nodes a side", "depth"}, {}};
    for (const ContactMode& mode : kContactModes) table.columns.push_back(short_name(mode));
    for (int nodes : {5, 9, 13})
        for (double depth_m : {0.001, 0.002}) {
            table.rows.push_back({fmt::format("{}", nodes), fmt::format("{:.0f} mm", 1e3 * depth_m)});
            for (const ContactMode& mode : kContactModes) {
                Line line;
                line.depth_m = depth_m;
                const Slide s = slide(bare(cube(nodes, mode, build / "lines")->model()), line);
                const double change = largest_change(s, true) / (s.n_per_m * 1e-3 * line.along.norm());
                table.rows.back().push_back(number(change, fmt::format("{:.2g}", change)));
            }
        }
    return table;
}

Number settling(const fs::path& build) {
    std::vector<double> difference;
    for (int nodes : {5, 9, 13})
        for (const ContactMode& mode : kContactModes) {
            Line line;
            line.depth_m = 0.002;
            const auto subject = cube(nodes, mode, build / "lines");
            const Slide coarse = slide(bare(subject->model()), line);
            line.ticks_per_ms = 100;
            line.ticks *= 100;
            const Slide fine = slide(bare(subject->model()), line);
            for (std::size_t i = 0; i < coarse.force.size(); ++i)
                difference.push_back((coarse.force[i] - fine.force[100 * i]).norm() / fine.force[100 * i].norm());
        }
    const auto at = difference.begin() + static_cast<std::ptrdiff_t>(0.999 * static_cast<double>(difference.size()));
    std::nth_element(difference.begin(), at, difference.end());
    return error_of(*at);
}

NumberTable jump_table(const fs::path& build) {
    NumberTable table{{"force", "1 mm deep", "2 mm deep"}, {}};
    for (std::size_t m : {3U, 4U, 5U}) {
        table.rows.push_back({word(kContactModes[m].force)});
        for (double depth_m : {0.001, 0.002}) {
            Line line;
            line.depth_m = depth_m;
            const Slide s = slide(bare(cube(9, kContactModes[m], build / "lines")->model()), line);
            table.rows.back().push_back(millinewtons(largest_change(s, false)));
        }
    }
    return table;
}

NumberTable release_table(const fs::path& build) {
    NumberTable table{{"release_slew", "20 mm/s", "100 mm/s"}, {}};
    const auto subject = cube(9, kContactModes[4], build / "lines");
    for (double slew : {0.0, 0.01, 0.005}) {
        haptable_model model = bare(subject->model());
        if (slew > 0.0) model.release = haptable_release_slew;
        model.release_n = static_cast<float>(slew);
        table.rows.push_back({slew > 0.0 ? fmt::format("{} N/ms", slew) : "0: none"});
        for (double speed : {0.02, 0.1}) {
            double largest = 0.0;
            for (int k = 0; k < 12; ++k) {
                Line line{{0.006, 0.008 + 0.001 * k, 0.03}, {speed, 0.3 * speed * (k % 2 ? 1 : -1), 0.0}, 0.002, 0, 1};
                line.ticks = static_cast<int>(0.018 / (1e-3 * speed));
                largest = std::max(largest, largest_change(slide(model, line), false));
            }
            table.rows.back().push_back(millinewtons(largest));
        }
    }
    return table;
}

}  // namespace haptable
