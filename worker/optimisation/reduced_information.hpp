#pragma once

#include <Eigen/SparseCore>
#include <ceres/problem.h>
#include <cstddef>
#include <functional>
#include <vector>

namespace divemesh::optimisation {

// The information of a bundle adjustment about all blocks but the landmarks, which are eliminated
// (Schur complement). Its inverse is the covariance of these blocks.
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

// Errors that all measurements share, such as those of the calibration. They are not estimated; the
// columns are the derivatives of the residuals with respect to them: those of the cameras first,
// then the sensors' clock, then the gyroscope's rates.
struct SharedJacobian {
    // Returns the three rows of the i-th observation, in the order of the problem, whose last
    // residuals are all observations.
    std::function<Eigen::Matrix3Xd(std::size_t observation)> of_observation;
    int num_columns = 0;
    // The derivative of the kept blocks that sensors other than the cameras measure, with respect
    // to the clock of those sensors. Empty: not wanted.
    Eigen::VectorXd by_time;  // one column more
    // The same for blocks that are held constant.
    struct Constant {
        double* block = nullptr;
        Eigen::VectorXd by_time;
    };
    std::vector<Constant> constants;
    // A residual of the gyroscope. Rates that are too large by a share act on it like a bias of
    // that share of them.
    struct OfRates {
        int first_row = 0;
        int num_rows = 0;
        int bias_column = 0;                             // of H, of the bias that it depends on
        Eigen::Vector3d rate = Eigen::Vector3d::Zero();  // mean over the motion, rad/s
    };
    std::vector<OfRates> of_rates;  // three columns more, an axis of the IMU each; empty: none

    int num_sensor_columns() const {
        return (by_time.size() > 0 ? 1 : 0) + (of_rates.empty() ? 0 : 3);
    }
};

// The information in the residuals about the shared errors themselves.
struct SharedScores {
    SharedScores(Eigen::Index num_kept, Eigen::Index num_columns)
        : information(Eigen::MatrixXd::Zero(num_columns, num_columns)),
          sum(Eigen::VectorXd::Zero(num_columns)),
          variances(Eigen::VectorXd::Zero(num_columns)),
          covariance(Eigen::MatrixXd::Zero(num_kept, num_columns)) {}

    Eigen::MatrixXd information;  // J_shared^T D J_shared, the landmarks eliminated
    Eigen::VectorXd sum;          // of the landmarks' scores
    Eigen::VectorXd variances;    // of that sum, if no error were shared
    Eigen::MatrixXd covariance;   // of the scores of the kept blocks with it
};

// The information about all blocks but the landmarks (H) and the variance of the landmarks' summed
// scores (V). Each landmark's score counts as one sample, so any correlation of its errors between
// images is included (Huber 1967; Liang and Zeger 1986). H is the derivative of the scores. Beyond
// Huber's bound the force of a residual does not depend on its length, so it has stiffness w across
// its direction and none along it:
//
//     D = w (I - r r^T / |r|^2)
//
// For errors in all directions the mean of D is w (m - 1) / m (m rows; Huber, "Robust Statistics",
// 1981, 7.6). The inertial sensors are taken to have their stated noise. The covariance is
//
//     P = H^-1 V H^-1
//
// and an error e that all measurements share moves the solution by -H^-1 B e.
struct ClusteredInformation {
    Eigen::SparseMatrix<double> H_lower;  // J^T D J, D: mean derivative of Huber's psi
    Eigen::SparseMatrix<double> V_lower;
    Eigen::MatrixXd B;       // J^T D J_shared
    SharedScores of_shared;  // the cameras' columns
    std::vector<int> start;  // of each kept block; -1: held constant
};
ClusteredInformation clustered_information(ceres::Problem& problem,
                                           const std::vector<double*>& kept,
                                           const std::vector<double*>& landmarks,
                                           double huber,
                                           const SharedJacobian& shared = {});

}  // namespace divemesh::optimisation
