#include "worker/optimisation/joint_influences.hpp"

namespace divemesh::optimisation {

JointInfluences::JointInfluences(Eigen::Index rows_per_state,
                                 std::ptrdiff_t num_states,
                                 Eigen::Index num_unknowns,
                                 Eigen::Index num_errors)
    : rows_per_state_(rows_per_state),
      influences_(num_unknowns, rows_per_state * num_states),
      covariance_(rows_per_state * num_states, rows_per_state * num_states),
      by_calibration_(rows_per_state * num_states, num_errors) {}

void JointInfluences::add(const Eigen::MatrixXd& influences,
                          const Eigen::MatrixXd& varied,
                          const Eigen::MatrixXd& by_calibration) {
    const Eigen::Index at = num_rows_;
    num_rows_ += rows_per_state_;
    influences_.middleCols(at, rows_per_state_) = influences.cast<float>();
    const Eigen::MatrixXd with_those_before =
        varied.transpose() * influences_.leftCols(num_rows_).cast<double>();
    covariance_.block(at, 0, rows_per_state_, num_rows_) = with_those_before;
    covariance_.block(0, at, num_rows_, rows_per_state_) = with_those_before.transpose();
    by_calibration_.middleRows(at, rows_per_state_) = by_calibration;
}

}  // namespace divemesh::optimisation
