// SPDX-License-Identifier: GPL-2.0-or-later
// haptable-bench-inversion: what the blocks of L cost by selected inversion and by solves, how cost grows, how exact
// they are: raw numbers as JSON, of which lab/programs.py makes tables. CPU seconds of one thread; memory is the
// largest resident set of the stage.
#include <fmt/format.h>
#include <malloc.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/base/process_cost.hpp"
#include "host/base/program.hpp"
#include "host/body/assembly.hpp"
#include "host/body/mask.hpp"
#include "host/inverse/column_solver.hpp"
#include "host/inverse/pairs.hpp"
#include "host/inverse/selected_inversion.hpp"
#include "host/inverse/solve/frame_solver.hpp"

namespace {

using namespace haptable;
namespace fs = std::filesystem;
using nlohmann::ordered_json;
using Nodes = std::vector<std::int32_t>;
using Blocks = std::vector<Eigen::Matrix3d>;
constexpr std::size_t kBlockNodes = 64;  // of one blocked solve: 192 right-hand sides

constexpr std::size_t kSampledGroups = 3;    // of right-hand sides that the solves are timed with
constexpr std::size_t kColumnNodes = 10000;  // bodies of at most so many nodes get their columns measured

/// The paper's cube, its base held.
Scene cube_scene(int nodes_per_side, double poisson) {
    Scene scene;
    scene.file = "cube.toml";
    scene.name = fmt::format("cube {}", nodes_per_side);
    scene.mesh.generate = "cube";
    scene.mesh.nodes_per_side = nodes_per_side;
    scene.material = {1e4, poisson};
    scene.fixed.push_back({std::array<double, 6>{-1, -1, -1, 1, 1, 1e-9}, "", 1});
    return scene;
}

/// CPU seconds of `work`.
template <typename Work>
double cost_of(const Work& work) {
    const double begin = process_cost().cpu_s;
    work();
    return process_cost().cpu_s - begin;
}

/// Lets the kernel count the largest resident set afresh.
void reset_peak() {
    malloc_trim(0);
    std::ofstream("/proc/self/clear_refs") << "5";
}

std::int32_t unknown_of(const Body& body, std::int32_t node) { return body.unknown[static_cast<std::size_t>(node)]; }

/// The free ones of the touchable nodes, by their unknowns.
Nodes touched_unknowns(const Body& body) {
    Nodes node;
    for (std::int32_t i : body.touch_node) node.push_back(unknown_of(body, i));
    return node;
}

/// Three right-hand sides a node: a force along each axis.
template <typename Scalar>
Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic> unit_forces(Eigen::Index unknowns, const Nodes& node) {
    using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
    Matrix b = Matrix::Zero(unknowns, 3 * static_cast<Eigen::Index>(node.size()));
    for (std::size_t c = 0; c < node.size(); ++c)
        b.template block<3, 3>(Eigen::Index{3} * node[c], 3 * static_cast<Eigen::Index>(c)).setIdentity();
    return b;
}

/// L_ii of the touchable nodes and L_ij of the edges of their patches.
std::vector<NodePair> wanted_of(const Body& body) {
    std::vector<NodePair> pairs;
    for (std::int32_t i : touched_unknowns(body)) pairs.push_back({i, i});
    for (const auto& [a, b] : sorted_edges(body.touch_patch))
        if (!body.is_fixed(a) && !body.is_fixed(b)) pairs.push_back({unknown_of(body, a), unknown_of(body, b)});
    return pairs;
}

/// Largest ||block - x_ij|| / sqrt(||L_ii|| ||L_jj||) over the wanted pairs whose column was solved for: x has three
/// columns of each node in `solved`.
double largest_error(const std::vector<NodePair>& wanted, const Blocks& blocks, const Nodes& solved,
                     const Eigen::MatrixXd& x) {
    std::map<std::int32_t, Eigen::Index> column;
    for (std::size_t c = 0; c < solved.size(); ++c) column[solved[c]] = 3 * static_cast<Eigen::Index>(c);
    std::map<std::int32_t, double> size;  // of L_ii
    for (std::size_t w = 0; w < wanted.size(); ++w)
        if (wanted[w].row == wanted[w].column) size[wanted[w].row] = blocks[w].norm();
    double largest = 0.0;
    for (std::size_t w = 0; w < wanted.size(); ++w) {
        const auto [row, of] = wanted[w];
        if (const auto at = column.find(of); at != column.end()) {
            const Eigen::Matrix3d expected = x.block<3, 3>(Eigen::Index{3} * row, at->second);
            largest = std::max(largest, (blocks[w] - expected).norm() / std::sqrt(size.at(row) * size.at(of)));
        }
    }
    return largest;
}

/// Blocked solves for all touchable nodes: timed with groups spread over them, and compared with the blocks.
void solve_sample(const Factor& factor, const Nodes& node, const std::vector<NodePair>& wanted, const Blocks& in_double,
                  const Blocks& in_float, ordered_json& row) {
    const std::size_t groups = (node.size() + kBlockNodes - 1) / kBlockNodes;
    const std::size_t run = std::min(groups, kSampledGroups);
    std::size_t solved = 0;
    double seconds = 0.0, double_error = 0.0, float_error = 0.0;
    for (std::size_t g = 0; g < run; ++g) {
        const std::size_t first = g * groups / run * kBlockNodes;
        const Nodes group(node.begin() + static_cast<std::ptrdiff_t>(first),
                          node.begin() + static_cast<std::ptrdiff_t>(std::min(node.size(), first + kBlockNodes)));
        const Eigen::MatrixXd b = unit_forces<double>(factor.size(), group);
        Eigen::MatrixXd x;
        if (g == 0) factor.solve(b, x);  // the first one takes its workspace from the system
        seconds += cost_of([&] { factor.solve(b, x); });
        solved += group.size();
        double_error = std::max(double_error, largest_error(wanted, in_double, group, x));
        float_error = std::max(float_error, largest_error(wanted, in_float, group, x));
    }
    const double sampled = static_cast<double>(solved) / static_cast<double>(node.size());
    row.update({{"solves_s", seconds / sampled},
                {"sampled", sampled},
                {"float_error", float_error},
                {"double_error", double_error}});
}

void measure_columns(const Factor& factor, const Nodes& node, ordered_json& row) {
    Progress progress(true);
    const std::size_t length = 9 * node.size();
    const auto solve_in = [&](Precision precision, double& seconds) {
        const ColumnSolver solver(factor.supernodes(), node, node, precision);
        Eigen::MatrixXf table(length, node.size());
        Columns::Sink put;
        put.take = [&](std::size_t i, std::size_t k, const Eigen::Matrix3f& block) {
            std::copy_n(block.data(), 9, &table(9 * static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(i)));
        };
        seconds = cost_of([&] { solver.compute(progress, put); });
        return table;
    };
    double double_s = 0.0, float_s = 0.0, error = 0.0;
    const Eigen::MatrixXf in_double = solve_in(Precision::kDouble, double_s);
    const Eigen::MatrixXf in_float = solve_in(Precision::kFloat, float_s);
    for (Eigen::Index i = 0; i < in_double.cols(); ++i) {
        const Eigen::VectorXd exact = in_double.col(i).cast<double>();
        error = std::max(error, (in_float.col(i).cast<double>() - exact).norm() / exact.norm());
    }
    row.update({{"columns_bytes", static_cast<std::size_t>(in_double.size()) * sizeof(float)},
                {"columns_double_s", double_s},
                {"columns_float_s", float_s},
                {"columns_error", error}});
}

/// The viewer's solve for one frame of patches spread over the surface, s of each.
void measure_frames(const Body& body, const Factor& factor, const Nodes& node, ordered_json& row) {
    constexpr std::size_t kFrames = 41;
    const Supernodes s = factor.supernodes();
    const std::vector<float> value(s.value, s.value + s.value_begin.back());
    FrameSolver solver(s, value.data(), node);
    Eigen::MatrixXd b(factor.size(), 1), x;
    for (std::size_t f = 0; f < kFrames; ++f) {
        const Patch& patch = body.touch_patch[f * body.touch_patch.size() / kFrames];
        std::vector<FrameSolver::Load> loads;
        b.setZero();
        for (std::int32_t corner : patch)
            if (const std::int32_t u = unknown_of(body, corner); u >= 0) {
                loads.push_back({u, {0.3F, -0.2F, -0.9F}});
                b.middleRows<3>(Eigen::Index{3} * u) << 0.3, -0.2, -0.9;
            }
        row["frame_s"].push_back(cost_of([&] { solver.displace(loads); }));
        row["plain_frame_s"].push_back(cost_of([&] { factor.solve(b, x); }));
    }
}

/// What was not measured is not there.
ordered_json measure(const Scene& scene) {
    const Body body = make_body(scene, make_mesh(scene.mesh));
    const Stiffness k = assemble_free(scene, body);
    const Nodes node = touched_unknowns(body);
    const std::vector<NodePair> wanted = wanted_of(body);
    ordered_json row{{"name", scene.name}, {"nodes", body.mesh.position_m.size()}, {"blocks", wanted.size()}};
    reset_peak();
    // 1. Ordering, analysis and factor.
    Progress progress(true);
    Workers alone(1);
    std::optional<Factor> factored;
    row["analysis_s"] = cost_of([&] { factored.emplace(k, Factor::kPattern); });
    row["factor_s"] = cost_of([&] { factored->factorize(k, alone, progress); });
    const Factor& factor = *factored;
    row.update({{"factor_flops", factor.flops()},
                {"factor_bytes", factor.bytes()},
                {"factor_peak", process_cost().peak_bytes}});
    // 2. The blocks by selected inversion, both ways.
    const SelectedInversion inversion(factor.supernodes(), wanted);
    row["inversion_flops"] = inversion.flops();
    Blocks in_float, in_double;
    reset_peak();
    row["float_s"] = cost_of([&] { in_float = inversion.compute<float>(progress); });
    row["float_peak"] = process_cost().peak_bytes;
    reset_peak();
    row["double_s"] = cost_of([&] { in_double = inversion.compute<double>(progress); });
    row["double_peak"] = process_cost().peak_bytes;
    // 3. The same by solves; the columns.
    solve_sample(factor, node, wanted, in_double, in_float, row);
    if (body.mesh.position_m.size() > kColumnNodes) return row;
    measure_columns(factor, node, row);
    measure_frames(body, factor, node, row);
    return row;
}

// ---- accuracy, against long double ----------------------------------------------------------------------------------

/// A cube whose cells are flattened or whose nodes are moved at random.
Body shaped_cube(const Scene& scene, double flatten, double jitter) {
    Body body = make_body(scene, make_mesh(scene.mesh));
    const double cell_m = scene.mesh.side_m / (scene.mesh.nodes_per_side - 1);
    for (std::size_t i = 0; i < body.mesh.position_m.size(); ++i) {
        Eigen::Vector3d& p = body.mesh.position_m[i];
        for (int c = 0; c < 3; ++c) p[c] += jitter * cell_m * std::sin(static_cast<double>((7 * i + 3) * (c + 1)));
        p.z() *= flatten;
    }
    return body;
}

/// Every column of L at the touchable nodes by a Cholesky factor in long double.
Eigen::MatrixXd exact_columns(const Eigen::SparseMatrix<double>& k, const Nodes& node) {
    const Eigen::SparseMatrix<long double> exact = k.cast<long double>();
    const Eigen::SimplicialLLT<Eigen::SparseMatrix<long double>> factor(exact);
    return factor.solve(unit_forces<long double>(k.rows(), node)).cast<double>();
}

ordered_json accuracy(int side) {
    struct Case {
        const char* name;
        double poisson, flatten, jitter;
    };
    const Case cases[] = {{"nu 0.3", 0.3, 1, 0},
                          {"nu 0.49", 0.49, 1, 0},
                          {"nu 0.4999", 0.4999, 1, 0},
                          {"nodes moved by 0.2 cells", 0.3, 1, 0.2},
                          {"slivers: cells 1/100 high", 0.3, 0.01, 0},
                          {"slivers, nu 0.4999", 0.4999, 0.01, 0.1}};
    ordered_json all = ordered_json::array();
    for (const Case& c : cases) {
        const Scene scene = cube_scene(side, c.poisson);
        const Body body = shaped_cube(scene, c.flatten, c.jitter);
        const Stiffness k = assemble_free(scene, body);
        const Nodes node = touched_unknowns(body);
        const std::vector<NodePair> wanted = wanted_of(body);
        const Factor factor(k);
        const SelectedInversion inversion(factor.supernodes(), wanted);
        Progress progress(true);
        const Blocks in_double = inversion.compute<double>(progress), in_float = inversion.compute<float>(progress);
        const Eigen::MatrixXd exact = exact_columns(k.matrix(), node);
        Eigen::MatrixXd x;
        factor.solve(unit_forces<double>(exact.rows(), node), x);
        Blocks solved;
        for (const NodePair& pair : wanted) {
            const auto column = std::find(node.begin(), node.end(), pair.column) - node.begin();
            solved.push_back(x.block<3, 3>(Eigen::Index{3} * pair.row, 3 * column));
        }
        all.push_back({{"name", c.name},
                       {"double", largest_error(wanted, in_double, node, exact)},
                       {"float", largest_error(wanted, in_float, node, exact)},
                       {"solves", largest_error(wanted, solved, node, exact)},
                       {"against_solves", largest_error(wanted, in_double, node, x)}});
    }
    return all;
}

}  // namespace

int main(int argc, char** argv) {
    CommandLine app("Measures selected inversion and pruned columns against blocked solves, on one thread.",
                    "haptable-bench-inversion");
    std::vector<int> sides{8, 12, 16, 20};
    std::vector<fs::path> scenes;
    bool with_accuracy = true;
    app.option("--sides", sides, "cubes of so many nodes a side").delimiter(',').range(2, 100).show_default();
    app.option("--scene", scenes, "scenes besides the cubes");
    app.flag("!--no-accuracy", with_accuracy, "no comparison with long double");
    return run_program(app, argc, argv, [&] {
        constexpr int kSide = 10;
        ordered_json all{{"block_nodes", kBlockNodes}, {"bodies", ordered_json::array()}};
        if (with_accuracy) all["accuracy"] = {{"side", kSide}, {"cases", accuracy(kSide)}};
        const auto add = [&](const Scene& scene, bool is_cube) {
            all["bodies"].push_back(measure(scene));
            all["bodies"].back()["is_cube"] = is_cube;
            fmt::print(stderr, "  measured {}\n", scene.name);
        };
        for (int side : sides) add(cube_scene(side, 0.3), true);
        for (const fs::path& file : scenes) add(read_scene(file), false);
        fmt::print("{}\n", all.dump());
    });
}
