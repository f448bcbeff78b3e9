// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/precompute/write_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/text.hpp"
#include "host/precompute/vtu.hpp"
#include "host/tables/npy.hpp"

namespace haptable {

namespace fs = std::filesystem;

namespace {

template <typename T, std::size_t k>
void write_rows(const fs::path& path, const std::vector<std::array<T, k>>& rows) {
    const T* first = rows.empty() ? nullptr : rows.front().data();
    write_npy<T>(path, {rows.size(), k}, std::span<const T>(first, k * rows.size()));
}

void write_position(const fs::path& path, const std::vector<Eigen::Vector3d>& position_m) {
    NpyWriter<double> writer(path, {position_m.size(), 3});
    for (const Eigen::Vector3d& p : position_m) writer.append(std::span<const double>(p.data(), 3));
    writer.close();
}

/// 3x3 blocks, row by row, as an array of that shape.
void write_blocks(const fs::path& path, const std::vector<std::size_t>& shape,
                  const std::vector<Eigen::Matrix3d>& blocks) {
    NpyWriter<double> writer(path, shape);
    for (const Eigen::Matrix3d& block : blocks) {
        const Eigen::Matrix3d rows = block.transpose();
        writer.append(std::span<const double>(rows.data(), 9));
    }
    writer.close();
}

template <std::size_t group>
std::vector<Eigen::Matrix3d> flat(const std::vector<std::array<Eigen::Matrix3d, group>>& grouped) {
    std::vector<Eigen::Matrix3d> blocks;
    for (const auto& one : grouped) blocks.insert(blocks.end(), one.begin(), one.end());
    return blocks;
}

/// How a load on a mask's control point is distributed over nodes: vertices first, then edges.
void write_mask_weights(const Masks& masks, const fs::path& folder) {
    std::vector<std::int32_t> begin{0}, node;
    std::vector<float> weight;
    for (const auto* list : {&masks.vertex, &masks.edge})
        for (const NodeWeights& one : *list) {
            node.insert(node.end(), one.node.begin(), one.node.end());
            for (double w : one.weight) weight.push_back(static_cast<float>(w));
            begin.push_back(static_cast<std::int32_t>(node.size()));
        }
    write_npy<std::int32_t>(folder / "spread_begin.npy", {begin.size()}, begin);
    write_npy<std::int32_t>(folder / "spread_node.npy", {node.size()}, node);
    write_npy<float>(folder / "spread_weight.npy", {weight.size()}, weight);
}

/// What the other files are told in, in the order in which they come into their place.
constexpr std::array kReports{"summary.json", "tables.json"};

}  // namespace

void write_tables(const Scene& scene, const Body& body, Drawing drawing,
                  const std::vector<Eigen::Matrix3d>& stiffness_n_per_m, std::span<const Eigen::Vector3d> sag_m,
                  const fs::path& folder) {
    std::vector<Eigen::Vector3d> position_m = body.mesh.position_m;
    for (std::size_t i = 0; i < sag_m.size(); ++i) position_m[i] += sag_m[i];
    write_position(folder / "position.npy", position_m);
    if (!sag_m.empty()) write_position(folder / "sag.npy", {sag_m.begin(), sag_m.end()});
    write_rows(folder / "surface.npy", body.surface.patch);
    write_rows(folder / "patch.npy", body.touch_patch);
    write_npy<std::int32_t>(folder / "node_id.npy", {body.touch_node.size()}, body.touch_node);
    write_blocks(folder / "stiffness.npy", {stiffness_n_per_m.size(), 3, 3}, stiffness_n_per_m);
    if (drawing != Drawing::kNone) {
        const std::vector<std::int32_t>& rows = rows_of(scene, body);
        write_npy<std::int32_t>(folder / "row_id.npy", {rows.size()}, rows);
    }
    write_file(folder / "mesh.vtu", to_vtu(scene, body, sag_m));
}

std::vector<Eigen::Vector3d> read_sag(const fs::path& folder) {
    const MappedNpy<double> file(folder / "sag.npy");
    std::vector<Eigen::Vector3d> sag_m;
    for (std::size_t k = 0; k + 2 < file.values().size(); k += 3)
        sag_m.emplace_back(file.values()[k], file.values()[k + 1], file.values()[k + 2]);
    return sag_m;
}

void write_edges(const Scene& scene, const Body& body, std::span<const Eigen::Matrix3d> l_ij, const fs::path& folder) {
    const auto edges = sorted_edges(body.touch_patch), coupled = coupled_edges(scene, body);
    std::vector<Eigen::Matrix3d> blocks;
    std::size_t next = 0;
    for (const auto& edge : edges) {
        const bool has = next < coupled.size() && coupled[next] == edge;
        blocks.push_back(has ? l_ij[next++] : Eigen::Matrix3d(Eigen::Matrix3d::Zero()));
    }
    write_rows(folder / "edge_id.npy", edges);
    write_blocks(folder / "edge_compliance.npy", {edges.size(), 1, 3, 3}, blocks);
}

void write_mask(const Masks& masks, const MaskCompliance& c, const fs::path& folder) {
    write_npy<std::int32_t>(folder / "vertex_id.npy", {masks.vertex_id.size()}, masks.vertex_id);
    write_rows(folder / "edge_id.npy", masks.edge_id);
    write_blocks(folder / "vertex_compliance.npy", {c.vertex.size(), 3, 3}, c.vertex);
    write_blocks(folder / "edge_compliance.npy", {c.edge.size(), 3, 3, 3}, flat(c.edge));
    write_blocks(folder / "patch_compliance.npy", {c.patch.size(), 3, 3, 3}, flat(c.patch));
    write_mask_weights(masks, folder);
}

std::vector<fs::path> files_in(const fs::path& folder) {
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
        if (std::find(kReports.begin(), kReports.end(), entry.path().filename()) == kReports.end())
            files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

void publish(const fs::path& beside, OwnFolder& folder) {
    std::set<std::string> names{"check.html"};
    for (const fs::path& file : files_in(beside)) names.insert(folder.file(file.filename()).filename());
    for (const char* name : kReports) {
        folder.file(name);
        folder.remove(name);
    }
    folder.clear(names);
    try {
        for (const fs::path& file : files_in(beside)) fs::rename(file, folder.path() / file.filename());
        for (const char* name : kReports) fs::rename(beside / name, folder.file(name));
    } catch (const fs::filesystem_error& error) {
        throw Error(fmt::format("{}: cannot be written: {}", folder.path().string(), error.code().message()));
    }
}

fs::path plain_folder(const fs::path& given) {
    const fs::path folder = fs::absolute(given).lexically_normal();
    return folder.has_filename() ? folder : folder.parent_path();
}

void require_room(const char* file, double needed_bytes, const fs::path& folder) {
    std::error_code unknown;
    const fs::space_info space = fs::space(folder, unknown);
    if (!unknown && needed_bytes > static_cast<double>(space.available))
        throw Error(
            fmt::format("{}: {} needs {} and {} are free; write elsewhere, touch a "
                        "smaller region or set columns = \"none\" in [tables]",
                        folder.string(), file, human_bytes(static_cast<std::uintmax_t>(needed_bytes)),
                        human_bytes(space.available)));
}

void touch_summary(const fs::path& folder) {
    std::error_code ignored;  // a folder that may only be read is no error: nothing was to be written
    fs::last_write_time(folder / "summary.json", fs::file_time_type::clock::now(), ignored);
}

}  // namespace haptable
