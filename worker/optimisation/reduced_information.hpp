#pragma once

#include <Eigen/SparseCore>
#include <ceres/problem.h>
#include <vector>

namespace divemesh::optimisation {

// What an adjustment knows of everything but the landmarks, which are eliminated (Schur
// complement): the inverse is the covariance of the rest.
struct ReducedInformation {
    Eigen::SparseMatrix<double> lower;  // of H; tangent coordinates of the kept blocks
    std::vector<int> start;             // of each kept block in H; -1: held constant
    double noise_scale = 1.0;           // of the cameras' residuals against the sigmas stated
};

// Of a solved problem. `landmarks`: blocks of three that residuals of three rows see, one of them
// each, after one another; `kept`: all other blocks. The cameras' noise is taken as their residuals
// show it, not as stated: with Huber's psi at `huber` sigmas,
//
//     scale^2 = n / (n - p) mean(|psi|^2 / rows) / mean(div psi / rows)^2
//
// the asymptotic covariance of an M-estimator (Huber, "Robust Statistics", 1981, 7.6), times
// (1 + c) / (1 - c) for neighbouring observations of a landmark that err alike with correlation c,
// as features do that are followed from picture to picture (Bartlett, 1946). Residuals beyond 5
// sigmas per row count for nothing, and less noise than stated is not believed. One thread: the
// same problem gives the same bits.
ReducedInformation reduced_information(ceres::Problem& problem,
                                       const std::vector<double*>& kept,
                                       const std::vector<double*>& landmarks,
                                       double huber);

// What an adjustment used of information about everything but the landmarks, and how far the sum of
// what the landmarks say varies: each landmark's score counts as one draw, so however its errors
// depend on each other from picture to picture, they are in it (Huber 1967; Liang and Zeger 1986).
// The inertial sensors are taken to err as stated. The covariance is
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
