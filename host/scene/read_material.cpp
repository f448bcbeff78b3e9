// SPDX-License-Identifier: GPL-2.0-or-later
#include "host/scene/read_material.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "host/base/error.hpp"
#include "host/scene/keys.hpp"
#include "host/scene/press_record.hpp"

namespace haptable {

namespace {

// Where a linear tetrahedron is half as stiff again as the body on any mesh of today.
constexpr double kMostPoissonOfLinear = 0.4999;

double read_modulus(const Section& section, std::string_view key, double value_pa) {
    if (!(value_pa > 0.0)) section.fail(key, fmt::format("is {} and must be greater than 0", value_pa));
    if (value_pa < kModulus.least || value_pa > kModulus.most)
        section.fail(key, fmt::format("is {} Pa and must lie in {}..{}", value_pa, kModulus.least, kModulus.most));
    return value_pa;
}

/// Linear tetrahedra have a bound below 0.5.
void require_compressible(const Section& section, double poisson, std::string_view like, Element element) {
    if (element == Element::kLinear && poisson > kMostPoissonOfLinear)
        section.fail("poisson",
                     fmt::format("{}is {}, and linear tetrahedra above {} give the mesh's stiffness, not the "
                                 "body's: write element = \"{}\" in [mesh]",
                                 like, poisson, kMostPoissonOfLinear, word(Element::kAverageNodalPressure)));
}

Material read_isotropic(const Section& section, Element element) {
    Material material;
    material.young_pa = read_modulus(section, "young", section.number("young"));
    material.poisson = section.number("poisson");
    if (!(material.poisson > -1.0 && material.poisson < 0.5))
        section.fail("poisson", fmt::format("is {} and must lie between -1 and 0.5, both excluded; 0.5 is "
                                            "incompressible, which this method cannot do: use 0.49",
                                            material.poisson));
    require_compressible(section, material.poisson, "", element);
    return material;
}

/// { curve = [c1, c2, c3], energy = e0 }: what haptable-fit gives.
StiffeningCurve read_curve(const Section& section) {
    StiffeningCurve curve;
    const std::vector<double> c =
        section.numbers("curve", 3, "three numbers of haptable-fit, [c1, c2, c3], or a record's path");
    std::copy(c.begin(), c.end(), curve.c.begin());
    curve.energy_j = section.number("energy");
    if (!(curve.energy_j > 0.0))
        section.fail("energy", fmt::format("is {} J and must be greater than 0", curve.energy_j));
    if (!curve.grows())
        section.fail("curve", "has a force that does not grow with the dent: take the numbers of haptable-fit");
    return curve;
}

/// { curve = "press.csv", at = [x, y, z], radius = r }: what haptable-fit would give.
Stiffening read_press(const Section& section) {
    if (section.has("energy")) section.fail("energy", "is the record's own: remove it");
    Stiffening stiffening;
    RecordedPress& press = stiffening.press.emplace();
    const std::vector<double> at = section.numbers("at", 3, "the place that was pressed, [x, y, z] in metres");
    std::copy(at.begin(), at.end(), press.at_m.begin());
    if (section.has("radius") && !((press.radius_m = section.number("radius")) > 0.0))
        section.fail("radius", fmt::format("is {} m and must be greater than 0", press.radius_m));
    try {
        press.file = section.beside("curve");
        const DentFit fit = fit_dent(read_force_record(press.file));
        stiffening.curve = fit.curve;
        press.depth_m = fit.depth_m;
        press.stiffness_n_per_m = fit.stiffness_n_per_m;
        press.misfit_n = fit.misfit_n;
    } catch (const Error& error) {
        section.fail("curve", error.what());
    }
    return stiffening;
}

/// One of two laws, { yeoh = [y2] }, { yeoh = [y2, y3] } or { fung = b }; or a curve.
Stiffening read_stiffening(const Section& section) {
    constexpr double kMost = 1e4;  // a body that is as stiff again at a strain of 1 %
    section.require_known({"yeoh", "fung", "curve", "energy", "at", "radius"});
    if (section.has("yeoh") + section.has("fung") + section.has("curve") != 1)
        section.fail("yeoh",
                     "give one law, { yeoh = [y2, y3] } or { fung = b }, or { curve = [c1, c2, c3], energy = e0 }, or "
                     "{ curve = \"press.csv\", at = [x, y, z] }");
    const bool is_record = section.has("curve") && section.find("curve")->is_string();
    for (std::string_view key : {"at", "radius"})
        if (section.has(key) && !is_record) section.fail(key, "belongs to curve = \"press.csv\": remove it");
    if (is_record) return read_press(section);
    if (section.has("curve")) return {.curve = read_curve(section)};
    const auto require = [&](std::string_view key, double value) {
        if (!(value >= 0.0 && value <= kMost))
            section.fail(key, fmt::format("has {} and must lie in 0..{:g}: a body that stiffens", value, kMost));
    };
    Stiffening stiffening;
    if (section.has("fung")) {
        stiffening.fung = section.number("fung");
        require("fung", stiffening.fung);
        if (!(stiffening.fung > 0.0)) section.fail("fung", "is 0, a body that does not stiffen: remove stiffening");
        return stiffening;
    }
    const toml::array* list = section.find("yeoh")->as_array();
    const bool has_one = list != nullptr && list->size() == 1;
    const std::vector<double> y = section.numbers("yeoh", has_one ? 1 : 2, "[y2] or [y2, y3], C20 / C10 and C30 / C10");
    for (const double value : y) require("yeoh", value);
    stiffening.y2 = y[0];
    if (!has_one) stiffening.y3 = y[1];
    if (!(stiffening.y2 + stiffening.y3 > 0.0))
        section.fail("yeoh", "is 0, a body that does not stiffen: remove stiffening");
    return stiffening;
}

using Vector = std::array<double, 3>;

double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Not 0, and the second not along the first.
void require_directions(const Section& section, std::string_view key, const Vector& first, const Vector* second) {
    const double a = dot(first, first);
    if (!(a > 0.0)) section.fail(key, "is 0, which is no direction");
    if (second == nullptr) return;
    const double b = dot(*second, *second), ab = dot(first, *second);
    constexpr double kLeastSine = 1e-6;
    if (!(b > 0.0) || !(a * b - ab * ab > kLeastSine * kLeastSine * a * b))
        section.fail(key, "its two directions must not be parallel, nor 0");
}

/// [[x, y, z], [x, y, z]]: a point of the axis and its direction.
void read_around(const Section& section, MaterialAxes& axes) {
    axes.around = section.two_vectors("around", "a point (m) and a direction, [[0, 0, 0], [0, 0, 1]]");
    require_directions(section, "around", (*axes.around)[1], nullptr);
}

/// One of three keys says how the material lies: `vectors`, `vectors`_field or around.
MaterialAxes read_axes(const Section& section, const std::string& vectors, bool two) {
    MaterialAxes axes;
    axes.line = section.line();
    const std::string field = vectors + "_field";
    if (section.has(vectors) + section.has(field) + section.has("around") != 1)
        section.fail(vectors, fmt::format("say how the material lies by one of {}, {} and around", vectors, field));
    if (section.has("around")) {
        read_around(section, axes);
    } else if (section.has(field)) {
        if (two)
            axes.field = section.two_texts(field, "two names of cell vectors of the mesh file, [\"u\", \"v\"]");
        else
            axes.field[0] = section.text(field);
        if (axes.field[0].empty()) section.fail(field, "is empty; name cell vectors of the mesh file");
        if (axes.field[0] == axes.field[1]) section.fail(field, "names one direction twice; a material has two");
    } else if (two) {
        axes.direction = section.two_vectors(vectors, "two directions, [[1, 0, 0], [0, 1, 0]]");
        require_directions(section, vectors, axes.direction[0], &axes.direction[1]);
    } else {
        const std::vector<double> v = section.numbers(vectors, 3, "a direction, [1, 0, 0]");
        std::copy(v.begin(), v.end(), axes.direction[0].begin());
        require_directions(section, vectors, axes.direction[0], nullptr);
    }
    return axes;
}

/// Both laws end alike: admissible, and as compressible as the element needs.
Material finish(const Section& section, const Orthotropic& law, Element element) {
    if (const std::string what = violated(law); !what.empty())
        section.fail("poisson", "the stiffness is not positive definite: " + what);
    Material material = like(law);
    require_compressible(section, material.poisson, "of the like isotropic material ", element);
    return material;
}

Material read_orthotropic(const Section& section, Element element) {
    const auto three = [&](std::string_view key, std::string_view example) {
        const std::vector<double> v = section.numbers(key, 3, example);
        return Vector{v[0], v[1], v[2]};
    };
    Orthotropic law{three("young", "three moduli, [E1, E2, E3]"), three("poisson", "three ratios, [nu12, nu13, nu23]"),
                    three("shear", "three moduli, [G12, G13, G23]"), read_axes(section, "axes", true)};
    for (double e : law.young_pa) read_modulus(section, "young", e);
    for (double g : law.shear_pa) read_modulus(section, "shear", g);
    return finish(section, law, element);
}

Material read_fibre(const Section& section, Element element) {
    const auto modulus = [&](std::string_view key) { return read_modulus(section, key, section.number(key)); };
    const double across = section.number("poisson_across");
    if (!(across > -1.0 && across < 1.0))
        section.fail("poisson_across", fmt::format("is {} and must lie between -1 and 1, both excluded", across));
    Orthotropic law =
        fibre(modulus("young_along"), modulus("young_across"), section.number("poisson"), across, modulus("shear"));
    law.axes = read_axes(section, "direction", false);
    return finish(section, law, element);
}

/// Keys of each law, besides a region's box or group.
const std::map<std::string, Names> kLaws{
    {"isotropic", {"law", "young", "poisson", "stiffening"}},
    {"orthotropic", {"law", "young", "poisson", "shear", "axes", "axes_field", "around"}},
    {"fibre",
     {"law", "young_along", "young_across", "poisson", "poisson_across", "shear", "direction", "direction_field",
      "around"}}};

}  // namespace

Material read_material(const Section& section, Element element) {
    const std::string law = section.has("law") ? section.text("law") : "isotropic";
    const Names& own = kLaws.at(law);
    for (const auto& [other, keys] : kLaws)
        for (std::string_view key : keys)
            if (section.has(key) && std::find(own.begin(), own.end(), key) == own.end())
                section.fail(key, fmt::format("does not belong to law = \"{}\", whose keys are {}", law,
                                              fmt::join(own.begin() + 1, own.end(), ", ")));
    if (law == "orthotropic") return read_orthotropic(section, element);
    if (law == "fibre") return read_fibre(section, element);
    Material material = read_isotropic(section, element);
    if (!section.has("stiffening")) return material;
    if (section.find("stiffening")->as_table() == nullptr)
        section.fail("stiffening", "must be a law in braces: { yeoh = [y2, y3] }, or { fung = b }");
    material.stiffening = read_stiffening(section.section("stiffening", true));
    return material;
}

}  // namespace haptable
