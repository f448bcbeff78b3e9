// SPDX-License-Identifier: GPL-2.0-or-later
// One point a configuration: its error against the body, its time a tick, its flash, its precompute time.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/base/progress.hpp"
#include "host/bench/error/specimen.hpp"

namespace haptable {

struct Point {
    std::string body, mesh, element, force, god_object, precision;
    double error = 0.0;         ///< of the force, RMS over the places, relative to the body's
    double mean = 0.0;          ///< of the normal force over the places, relative to the body's: signed
    double tick_s = 0.0;        ///< CPU time of a tick while sliding
    double flash_bytes = 0.0;   ///< of the tables, or of what stands in their place
    double precompute_s = 0.0;  ///< CPU time of all threads, scene to C
};

/// Every configuration of one mesh of a specimen; quick: without those that take seconds to make.
std::vector<Point> measure_points(const Specimen& specimen, const Meshed& meshed, const std::vector<Truth>& truths,
                                  const std::filesystem::path& build, bool quick, Progress& progress);

/// What one would do instead, with the mask's loads: a product with the dense inverse of the surface, a solve a tick
/// with a kept factor, conjugate gradients from the last tick's solution.
std::vector<Point> measure_instead(const Specimen& specimen, const Meshed& meshed, const std::vector<Truth>& truths);

/// As measured; lab/points.py tells what follows: which are best, the order, the paper's own beside them.
NumberTable point_table(const std::vector<Point>& points);

/// Middle one of an odd number of samples.
double median(std::vector<double> samples);

/// Force, N, that the body gives a finger that deep. One that is held on the surface, as by the nearest god-object,
/// meets S u. One that slides without friction, as with least energy, gives way along the surface: its force is along
/// the normal n, depth / (n . C n), and on a thin body much less.
Eigen::Vector3d force_of_body(const Truth& truth, bool slides, double depth_m);

/// |f - f_body| / |f_body|
double error_of_force(const Eigen::Vector3d& force_n, const Eigen::Vector3d& body_n);

}  // namespace haptable
