// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/view/stress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>

#include "host/base/error.hpp"
#include "host/base/file.hpp"
#include "host/base/index.hpp"
#include "host/base/vtu_text.hpp"

namespace haptable {

namespace {

using Eigen::Index;
using Nodes = std::vector<std::int32_t>;  // 4 or 10, in VTK's order

/// A material of options.json in its own directions.
struct Law {
    Hooke own;
    bool has_directions = false;
};

Law read_law(const nlohmann::ordered_json& material) {
    using Three = std::array<double, 3>;
    if (material.at("law") == "orthotropic")
        return {orthotropic_hooke(material.at("young").get<Three>(), material.at("poisson").get<Three>(),
                                  material.at("shear").get<Three>()),
                true};
    return {isotropic_hooke(Lame::from_young(material.at("young"), material.at("poisson")))};
}

/// The scene's material, then those of its regions.
std::vector<Law> read_laws(const TablesFolder& folder) {
    const SceneOptions options = folder.options();
    try {
        std::vector<Law> laws{read_law(options.at("material"))};
        if (options.has("region"))
            for (const auto& region : options.at("region")) laws.push_back(read_law(region));
        return laws;
    } catch (const nlohmann::json::exception&) {
        folder.fail("options.json", "does not tell the material");
    }
}

/// mesh.vtu, as precompute writes it.
class MeshFile {
public:
    explicit MeshFile(const std::filesystem::path& file) : name_(file.string()), text_(read_file(file)) {}

    /// The numbers of a data array.
    template <typename Number>
    std::vector<Number> numbers(const std::string& array) const {
        const std::size_t tag = text_.find("Name=\"" + array + "\"");
        const std::size_t begin = tag == std::string::npos ? tag : text_.find('>', tag);
        if (begin == std::string::npos) throw Error(name_ + ": has no " + array + ": make the tables again");
        std::istringstream in(text_.substr(begin + 1, text_.find('<', begin) - begin - 1));
        std::vector<Number> out;
        for (Number value = 0; in >> value;) out.push_back(value);
        return out;
    }

    /// The tetrahedra, which stand before the patches.
    std::vector<Nodes> tets() const {
        const auto node = numbers<std::int32_t>("connectivity"), type = numbers<std::int32_t>("types");
        std::vector<Nodes> tets;
        auto next = node.begin();
        for (const std::int32_t one : type) {
            const int nodes = one == kVtkTetra ? 4 : one == kVtkQuadraticTetra ? 10 : 0;
            if (nodes == 0) break;
            if (node.end() - next < nodes) damaged();
            tets.emplace_back(next, next + nodes);
            next += nodes;
        }
        return tets;
    }

    [[noreturn]] void damaged() const { throw Error(name_ + ": is damaged: make the tables again"); }
    [[noreturn]] void does_not_fit() const { throw Error(name_ + ": does not fit the tables: make them again"); }

private:
    std::string name_, text_;
};

/// D of each tetrahedron, in the body's directions.
class ElementLaws {
public:
    ElementLaws(std::vector<Law> law, const MeshFile& file) : law_(std::move(law)), file_(file) {
        if (law_.size() > 1) region_ = file.numbers<std::int32_t>("region");
        if (std::any_of(law_.begin(), law_.end(), [](const Law& one) { return one.has_directions; }))
            for (std::size_t k = 0; k < 3; ++k) axis_[k] = file.numbers<double>(fmt::format("material_axis_{}", k + 1));
    }

    Hooke of(std::size_t tet) const {
        const Law& law = law_[place_of(tet)];
        return law.has_directions ? turned(law.own, axes_of(tet)) : law.own;
    }

private:
    std::size_t place_of(std::size_t tet) const {
        if (region_.empty()) return 0;
        if (tet >= region_.size() || region_[tet] < -1 || at(region_[tet] + 1) >= law_.size()) file_.does_not_fit();
        return at(region_[tet] + 1);
    }
    Eigen::Matrix3d axes_of(std::size_t tet) const {
        Eigen::Matrix3d axes;
        for (std::size_t k = 0; k < 3; ++k) {
            if (axis_[k].size() < 3 * tet + 3) file_.does_not_fit();
            axes.col(static_cast<Index>(k)) = Eigen::Vector3d(axis_[k].data() + 3 * tet);
        }
        return axes;
    }

    std::vector<Law> law_;
    const MeshFile& file_;
    std::vector<std::int32_t> region_;  ///< [T] -1: the scene's material
    std::array<std::vector<double>, 3> axis_;
};

using Patch = std::array<std::int32_t, 3>;

Patch sorted(Patch patch) {
    std::sort(patch.begin(), patch.end());
    return patch;
}

/// What the surface has of the face that a corner is not in: the face, or of quadratic tetrahedra its middle quarter.
Patch surface_part(const Nodes& tet, std::size_t left_out) {
    Patch part{};
    std::size_t next = 0;
    if (tet.size() == 4)
        for (std::size_t c = 0; c < 4; ++c) {
            if (c != left_out) part[next++] = tet[c];
        }
    else
        for (std::size_t e = 0; e < 6; ++e)
            if (kTetEdges[e][0] != left_out && kTetEdges[e][1] != left_out) part[next++] = tet[4 + e];
    return sorted(part);
}

/// Where a node is in its tetrahedron.
Eigen::Vector4d place_of(std::size_t node) {
    Eigen::Vector4d t = Eigen::Vector4d::Zero();
    if (node < 4)
        t[static_cast<Index>(node)] = 1.0;
    else
        for (const std::size_t corner : kTetEdges[node - 4]) t[static_cast<Index>(corner)] = 0.5;
    return t;
}

/// Rows and surface nodes of mesh nodes.
class NodePlaces {
public:
    NodePlaces(const Tables& tables, const DrawnSurface& surface, const MeshFile& file)
        : position_m_(tables.position),
          file_(file),
          fixed_(file.numbers<std::int32_t>("fixed")),
          row_(tables.position.size(), -1),
          drawn_(row_) {
        if (fixed_.size() != row_.size()) file.does_not_fit();
        for (std::size_t r = 0; r < tables.row_id.size(); ++r)
            row_[at(tables.row_id[r])] = static_cast<std::int32_t>(r);
        for (std::size_t i = 0; i < surface.nodes(); ++i) drawn_[at(surface.node_id[i])] = static_cast<std::int32_t>(i);
    }

    /// -1: fixed
    std::int32_t row(std::int32_t node) const {
        if (row_[at(node)] < 0 && fixed_[at(node)] == 0)
            throw Error(
                fmt::format("columns.npy has no row of node {}, inside the body, for --color stress: set "
                            "columns = \"all\" under [tables] of the scene and make the tables again",
                            node));
        return row_[at(node)];
    }
    /// -1: inside
    std::int32_t drawn(std::int32_t node) const { return drawn_[at(node)]; }

    Eigen::Matrix3Xd positions_m(const Nodes& tet) const {
        Eigen::Matrix3Xd at_m(3, static_cast<Index>(tet.size()));
        for (std::size_t a = 0; a < tet.size(); ++a) {
            if (tet[a] < 0 || at(tet[a]) >= position_m_.size()) file_.does_not_fit();
            at_m.col(static_cast<Index>(a)) = Eigen::Vector3d(position_m_[at(tet[a])].data());
        }
        return at_m;
    }

private:
    const decltype(Tables::position)& position_m_;
    const MeshFile& file_;
    std::vector<std::int32_t> fixed_, row_, drawn_;
};

/// The shape functions' gradients at one of the nodes, 1/m.
Eigen::Matrix3Xd gradients_at(std::size_t node, const Eigen::Matrix3Xd& at_m) {
    if (at_m.cols() == 10) return tet_point(at_m, place_of(node)).gradient_per_m;
    return tet_geometry({at_m.col(0), at_m.col(1), at_m.col(2), at_m.col(3)}).gradient_per_m;
}

StressedElement stressed_element(const Nodes& tet, const Hooke& law, const NodePlaces& nodes) {
    const Eigen::Matrix3Xd at_m = nodes.positions_m(tet);
    const bool is_linear = tet.size() == 4;
    StressedElement element;
    for (const std::int32_t node : tet) element.row.push_back(nodes.row(node));
    for (std::size_t a = 0; a < tet.size(); ++a) {
        if (nodes.drawn(tet[a]) < 0) continue;
        if (element.place.empty() || !is_linear)
            element.place.push_back({deviator_map(law, gradients_at(a, at_m)), {}});
        element.place.back().drawn.push_back(nodes.drawn(tet[a]));
    }
    return element;
}

}  // namespace

DeviatorMap deviator_map(const Hooke& law, const Eigen::Ref<const Eigen::Matrix3Xd>& gradient_per_m) {
    // In double until the mean is gone: near incompressibility it is much the larger part.
    Hooke deviator = law;
    deviator.topRows<3>().rowwise() -= law.topRows<3>().colwise().mean().eval();
    DeviatorMap map(6, 3 * gradient_per_m.cols());
    for (Index a = 0; a < gradient_per_m.cols(); ++a)
        for (Index i = 0; i < 3; ++i) {
            Gradient unit = Gradient::Zero();
            unit.row(i) = gradient_per_m.col(a).transpose();
            map.col(3 * a + i) = (deviator * strain_of(unit)).cast<float>();
        }
    return map;
}

float von_mises(const Eigen::Matrix<float, 6, 1>& deviator_pa) {
    return std::sqrt(1.5F * (deviator_pa.head<3>().squaredNorm() + 2.0F * deviator_pa.tail<3>().squaredNorm()));
}

SurfaceStress::SurfaceStress(const Tables& tables, const TablesFolder& folder, const DrawnSurface& surface)
    : share_(surface.nodes(), 0.0F) {
    const MeshFile file(folder.file("mesh.vtu"));
    const ElementLaws laws(read_laws(folder), file);
    const NodePlaces nodes(tables, surface, file);
    const std::vector<Nodes> tets = file.tets();
    std::set<Patch> patches;
    for (const Patch& patch : tables.surface) patches.insert(sorted(patch));
    for (std::size_t t = 0; t < tets.size(); ++t) {
        const auto is_patch = [&](std::size_t corner) { return patches.contains(surface_part(tets[t], corner)); };
        if (is_patch(0) || is_patch(1) || is_patch(2) || is_patch(3))
            element_.push_back(stressed_element(tets[t], laws.of(t), nodes));
    }
    for (const StressedElement& element : element_)
        for (const StressedElement::Place& place : element.place)
            for (const std::int32_t i : place.drawn) share_[at(i)] += 1.0F;
    for (float& share : share_) share = share > 0.0F ? 1.0F / share : 0.0F;
}

void SurfaceStress::find(std::span<const float> displacement_m, std::vector<float>& stress_pa) const {
    stress_pa.assign(share_.size(), 0.0F);
    Eigen::Matrix<float, Eigen::Dynamic, 1, 0, 30, 1> u;
    for (const StressedElement& element : element_) {
        u.setZero(3 * static_cast<Index>(element.row.size()));
        for (std::size_t a = 0; a < element.row.size(); ++a)
            if (element.row[a] >= 0)
                u.segment<3>(3 * static_cast<Index>(a)) =
                    Eigen::Vector3f(displacement_m.data() + 3 * at(element.row[a]));
        for (const StressedElement::Place& place : element.place) {
            const float stress = von_mises(place.deviator_pa_per_m * u);
            for (const std::int32_t i : place.drawn) stress_pa[at(i)] += stress * share_[at(i)];
        }
    }
}

}  // namespace haptable
