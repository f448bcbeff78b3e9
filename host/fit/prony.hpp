// SPDX-License-Identifier: GPL-2.0-or-later
// Stiffness and relaxation of a body from one measured press, by least squares.
#pragma once

#include <vector>

#include "host/base/relaxation.hpp"
#include "host/scene/press_record.hpp"

namespace haptable {

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
/// where the record has no times, or too few samples for its terms.
PronyFit fit_prony(const ForceRecord& record, std::size_t terms, std::size_t most_terms);

}  // namespace haptable
