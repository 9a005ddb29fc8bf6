#pragma once

#include <Eigen/SparseCore>
#include <ceres/problem.h>
#include <vector>

namespace divemesh::optimisation {

// The information of an adjustment about all blocks but the landmarks, which are eliminated (Schur
// complement). Its inverse is the covariance of these blocks.
struct ReducedInformation {
    Eigen::SparseMatrix<double> lower;  // of H; tangent coordinates of the kept blocks
    std::vector<int> start;             // of each kept block in H; -1: held constant
    double noise_scale = 1.0;           // of the cameras' residuals relative to the stated sigmas
};

// Returns the information of a solved problem. `landmarks` are blocks of three numbers, each
// observed by residuals of three rows that follow each other; `kept` are all other blocks. The
// cameras' noise is estimated from their residuals, with Huber's psi at `huber` sigmas,
//
//     scale^2 = n / (n - p) mean(|psi|^2 / rows) / mean(div psi / rows)^2
//
// the asymptotic covariance of an M-estimator (Huber, "Robust Statistics", 1981, 7.6), times (1 +
// c) / (1 - c) for neighbouring observations of a landmark whose errors have correlation c, as
// tracked features do (Bartlett, 1946). Residuals beyond 5 sigmas per row get weight 0, and the
// scale is at least 1. Single-threaded: the same problem gives the same bits.
ReducedInformation reduced_information(ceres::Problem& problem,
                                       const std::vector<double*>& kept,
                                       const std::vector<double*>& landmarks,
                                       double huber);

// The information about all blocks but the landmarks (H) and the variance of the landmarks' summed
// scores (V). Each landmark's score counts as one sample, so any correlation of its errors between
// images is included (Huber 1967; Liang and Zeger 1986). The inertial sensors are taken to have
// their stated noise. The covariance is
//
//     P = H^-1 V H^-1
struct ClusteredInformation {
    Eigen::SparseMatrix<double> H_lower;  // J^T W J with Huber's weights
    Eigen::SparseMatrix<double> V_lower;
    std::vector<int> start;  // of each kept block; -1: held constant
};
ClusteredInformation clustered_information(ceres::Problem& problem,
                                           const std::vector<double*>& kept,
                                           const std::vector<double*>& landmarks,
                                           double huber);

}  // namespace divemesh::optimisation
