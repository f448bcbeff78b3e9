// SPDX-License-Identifier: GPL-2.0-or-later
// Stiffness and relaxation of a body from one measured press, by least squares.
#pragma once

#include <filesystem>
#include <vector>

#include "host/base/relaxation.hpp"

namespace haptable {

/// A measured press: how deep, how hard, when.
struct ForceRecord {
    std::vector<double> time_s, depth_m, force_n;  ///< [samples]; time ascends
};

/// A file with the header time_s,depth_m,force_n and a sample a line, the force that of the body against the press.
/// What comes after the body has let go (no force, after the largest) is left out: there the depth is not its
/// surface's. Throws Error "FILE:LINE: what is wrong".
ForceRecord read_force_record(const std::filesystem::path& file);

struct PronyFit {
    double stiffness_n_per_m = 0.0;          ///< at once
    std::vector<RelaxationTerm> relaxation;  ///< by ascending time
    double stiffness_error = 0.0;            ///< standard deviations, as parts of each, from the noise that is left
    std::vector<double> share_error, time_error;
    double misfit_n = 0.0;        ///< root of the mean squared difference
    std::vector<double> force_n;  ///< [samples] of the fit
};

/// F(t) = k (rest d + sum share_k c_k), c_k the depth d convolved with exp(-t / time_k): what a spring of k N/m that
/// relaxes gives where the record's depth goes straight from sample to sample and was 0 before the first.
std::vector<double> relaxed_force(const ForceRecord& record, double stiffness_n_per_m,
                                  const std::vector<RelaxationTerm>& relaxation);

/// Least squares over stiffness, shares and times (Levenberg and Marquardt), from times spread evenly over the record's
/// decades; so many terms, or with 0 those at which Schwarz's criterion is least, up to `most_terms`; fewer, where the
/// record does not determine each number of a term to half of itself. Throws Error
/// where the record has too few samples for its terms.
PronyFit fit_prony(const ForceRecord& record, std::size_t terms, std::size_t most_terms);

}  // namespace haptable
