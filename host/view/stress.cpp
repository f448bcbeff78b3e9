// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/stress.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/vtu_text.hpp"

namespace haptable {

namespace {

using Tet = std::array<std::int32_t, 4>;

/// The shear modulus of a scene of one isotropic material and linear tetrahedra.
float read_shear(const std::filesystem::path& folder) {
    const std::filesystem::path file = folder / "summary.json";
    const auto json = nlohmann::json::parse(read_file(file), nullptr, false);
    const auto refuse = [&](const char* why) {
        throw Error(fmt::format("{}: --color stress is of linear tetrahedra of one isotropic material, and {}",
                                file.string(), why));
    };
    try {
        if (json.at("element").at("name") != "linear") refuse("this scene has other elements");
        if (json.contains("regions")) refuse("this scene has regions of others");
        if (json.at("material").contains("shear_pa")) refuse("this one has directions");
        const double young_pa = json.at("material").at("young_pa"), poisson = json.at("material").at("poisson");
        return static_cast<float>(young_pa / (2.0 * (1.0 + poisson)));
    } catch (const nlohmann::json::exception&) {
        throw Error(file.string() + ": does not tell the material: make the tables again");
    }
}

/// The numbers of a data array of mesh.vtu, as precompute writes it.
std::vector<std::int32_t> numbers(const std::string& text, const std::string& name, const std::filesystem::path& file) {
    const std::size_t tag = text.find("Name=\"" + name + "\"");
    const std::size_t begin = tag == std::string::npos ? tag : text.find('>', tag);
    if (begin == std::string::npos) throw Error(file.string() + ": has no " + name + ": make the tables again");
    std::istringstream in(text.substr(begin + 1, text.find('<', begin) - begin - 1));
    std::vector<std::int32_t> out;
    for (std::int32_t value = 0; in >> value;) out.push_back(value);
    return out;
}

/// True where one of its faces is a patch.
bool is_at_surface(const Tet& tet, const std::set<std::array<std::int32_t, 3>>& patches) {
    for (std::size_t left_out = 0; left_out < 4; ++left_out) {
        std::array<std::int32_t, 3> face{};
        for (std::size_t c = 0, k = 0; c < 4; ++c)
            if (c != left_out) face[k++] = tet[c];
        std::sort(face.begin(), face.end());
        if (patches.contains(face)) return true;
    }
    return false;
}

std::vector<Tet> surface_tets(const Tables& tables, const std::string& text, const std::filesystem::path& file) {
    const std::vector<std::int32_t> node = numbers(text, "connectivity", file), type = numbers(text, "types", file);
    std::set<std::array<std::int32_t, 3>> patches;
    for (std::array<std::int32_t, 3> patch : tables.surface) {
        std::sort(patch.begin(), patch.end());
        patches.insert(patch);
    }
    std::vector<Tet> tets;
    for (std::size_t t = 0; t < type.size() && type[t] == kVtkTetra; ++t) {
        if (4 * t + 4 > node.size()) throw Error(file.string() + ": is damaged: make the tables again");
        const Tet tet{node[4 * t], node[4 * t + 1], node[4 * t + 2], node[4 * t + 3]};
        if (is_at_surface(tet, patches)) tets.push_back(tet);
    }
    return tets;
}

}  // namespace

Eigen::Matrix<float, 3, 4> shape_gradients(const std::array<Eigen::Vector3d, 4>& corner_m) {
    Eigen::Matrix3d edges;
    for (std::size_t c = 1; c < 4; ++c)
        edges.row(static_cast<Eigen::Index>(c - 1)) = (corner_m[c] - corner_m[0]).transpose();
    const Eigen::Matrix3d gradients = edges.inverse();
    Eigen::Matrix<float, 3, 4> out;
    out.rightCols<3>() = gradients.cast<float>();
    out.col(0) = -gradients.rowwise().sum().cast<float>();
    return out;
}

float von_mises(float shear_pa, const Eigen::Matrix<float, 3, 4>& gradient_per_m,
                const Eigen::Matrix<float, 3, 4>& displacement_m) {
    const Eigen::Matrix3f gradient = displacement_m * gradient_per_m.transpose();
    Eigen::Matrix3f strain = 0.5F * (gradient + gradient.transpose());
    strain -= strain.trace() / 3.0F * Eigen::Matrix3f::Identity();
    return 2.0F * shear_pa * std::sqrt(1.5F) * strain.norm();
}

SurfaceStress::SurfaceStress(const Tables& tables, const std::filesystem::path& folder, const DrawnSurface& surface)
    : shear_pa_(read_shear(folder)), share_(surface.nodes(), 0.0F) {
    const std::filesystem::path file = folder / "mesh.vtu";
    const std::string text = read_file(file);
    const std::vector<std::int32_t> fixed = numbers(text, "fixed", file);
    std::vector<std::int32_t> row(tables.position.size(), -1), drawn(tables.position.size(), -1);
    for (std::size_t r = 0; r < tables.row_id.size(); ++r)
        row[static_cast<std::size_t>(tables.row_id[r])] = static_cast<std::int32_t>(r);
    for (std::size_t i = 0; i < surface.nodes(); ++i)
        drawn[static_cast<std::size_t>(surface.node_id[i])] = static_cast<std::int32_t>(i);
    for (const Tet& tet : surface_tets(tables, text, file)) {
        Element element;
        std::array<Eigen::Vector3d, 4> corner_m;
        for (std::size_t c = 0; c < 4; ++c) {
            const auto node = static_cast<std::size_t>(tet[c]);
            if (node >= fixed.size() || node >= row.size())
                throw Error(file.string() + ": does not fit the tables: make them again");
            if (row[node] < 0 && fixed[node] == 0)
                throw Error(
                    fmt::format("{}: has no row of node {}, inside the body, for --color stress: set columns = "
                                "\"all\" under [tables] of the scene and make the tables again",
                                (folder / "columns.npy").string(), node));
            element.row[c] = row[node];
            element.drawn[c] = drawn[node];
            corner_m[c] = Eigen::Vector3d(tables.position[node].data());
            if (drawn[node] >= 0) share_[static_cast<std::size_t>(drawn[node])] += 1.0F;
        }
        element.gradient_per_m = shape_gradients(corner_m);
        element_.push_back(element);
    }
    for (float& share : share_) share = share > 0.0F ? 1.0F / share : 0.0F;
}

void SurfaceStress::find(std::span<const float> displacement_m, std::vector<float>& stress_pa) const {
    stress_pa.assign(share_.size(), 0.0F);
    for (const Element& element : element_) {
        Eigen::Matrix<float, 3, 4> u = Eigen::Matrix<float, 3, 4>::Zero();
        for (int c = 0; c < 4; ++c)
            if (const std::int32_t r = element.row[static_cast<std::size_t>(c)]; r >= 0)
                u.col(c) = Eigen::Vector3f(displacement_m.data() + 3 * static_cast<std::size_t>(r));
        const float stress = von_mises(shear_pa_, element.gradient_per_m, u);
        for (const std::int32_t i : element.drawn)
            if (i >= 0) stress_pa[static_cast<std::size_t>(i)] += stress * share_[static_cast<std::size_t>(i)];
    }
}

}  // namespace haptable
