// SPDX-License-Identifier: GPL-2.0-or-later
// A body that stiffens: its material, and the curve that a contact's energy follows.
#pragma once

#include <array>
#include <filesystem>
#include <optional>

namespace haptable {

/// A contact whose linear energy is e stores Psi(e) and has Psi'(e) times the linear force:
/// Psi' = 1 + c_1 s + c_2 s^2 + c_3 s^3,   s = min(1, sqrt(e / e_0))
struct StiffeningCurve {
    std::array<double, 3> c{};
    double energy_j = 0.0;  ///< e_0, > 0; 0: a linear body

    double factor(double e_j) const;
    /// True where force and stiffness are positive at any energy.
    bool grows() const;
    /// The least of Psi' and of the tangent, at any energy.
    double least_tangent() const;
    /// Psi' + 2 e Psi'': of the stiffness along the load.
    double tangent(double e_j) const;
    /// Psi, J.
    double stored(double e_j) const;
    /// Largest tangent of any energy up to that one.
    double largest_tangent(double e_j) const;
    /// The linear energy, J, where a spring of k, N/m, gives the force, N.
    double energy_at(double force_n, double k_n_per_m) const;
};

/// A slow press that somebody measured, and where.
struct RecordedPress {
    std::filesystem::path file;
    std::array<double, 3> at_m{};    ///< of the surface, in the scene's frame
    double radius_m = 0.0;           ///< of the mask that pressed; 0: the scene's finger
    double depth_m = 0.0;            ///< of the deepest sample
    double stiffness_n_per_m = 0.0;  ///< of a small dent
    double misfit_n = 0.0;           ///< of the curve, root mean square
};

/// How the shear stiffness of an isotropic body grows with its strain, x = J^(-2/3) tr F^T F - 3: the energy mu/2 w(x),
/// w(x) = x + y_2 x^2 + y_3 x^3 (Yeoh 1993), or (e^(b x) - 1) / b (Fung; Demiray 1972).
struct Stiffening {
    double y2 = 0.0, y3 = 0.0;                ///< >= 0
    double fung = 0.0;                        ///< b; > 0: the exponential, and y_2 and y_3 are 0
    StiffeningCurve curve;                    ///< or what a record gave, instead of a law; energy 0: there is none
    std::optional<RecordedPress> press = {};  ///< that record, whose stiffness the curve's energy is of

    double w(double x) const;
    /// dw/dx, 1 at 0.
    double slope(double x) const;
};

}  // namespace haptable
