#pragma once

#include <Eigen/Core>
#include <cstddef>

namespace divemesh::optimisation {

// Collects a joint covariance, state by state: that of what was measured, G^T V G with the
// influences G = H^-1 E of the states' rows E and the variance V of the scores (the sandwich of
// Huber 1967), and what each independent error of the calibration moves the rows by.
class JointInfluences {
public:
    // `rows_per_state`: 3 for positions, 6 for poses.
    JointInfluences(Eigen::Index rows_per_state,
                    std::ptrdiff_t num_states,
                    Eigen::Index num_unknowns,
                    Eigen::Index num_errors);

    // Adds a state: the influences of its rows on the unknowns, a column per row, the same times V,
    // and by how much each error of the calibration moves the rows.
    void add(const Eigen::MatrixXd& influences,
             const Eigen::MatrixXd& varied,
             const Eigen::MatrixXd& by_calibration);

    Eigen::MatrixXd& covariance() { return covariance_; }
    Eigen::MatrixXd& by_calibration() { return by_calibration_; }

private:
    Eigen::Index rows_per_state_;
    Eigen::Index num_rows_ = 0;
    Eigen::MatrixXf influences_;  // single precision: an hour's dive has gigabytes of them
    Eigen::MatrixXd covariance_;
    Eigen::MatrixXd by_calibration_;
};

}  // namespace divemesh::optimisation
