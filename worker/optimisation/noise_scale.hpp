#pragma once

#include <Eigen/Core>

namespace divemesh::optimisation {

constexpr double kOutlierSigmas = 5.0;  // per row; residuals beyond get weight 0

// The noise of the cameras' residuals relative to the stated sigmas, by Huber's psi over whole
// residuals at `huber` sigmas:
//
//     scale^2 = n / (n - p) mean(|psi|^2 / rows) / mean(div psi / rows)^2 (1 + c) / (1 - c)
//
// c: correlation of neighbouring observations of a landmark.
class NoiseScale {
public:
    explicit NoiseScale(double huber) : huber_(huber) {}

    // Adds the next observation of a landmark, whose first `rows` rows were measured. `before` is
    // its previous observation, nullptr for the first.
    void add(const Eigen::Vector3d& r, const Eigen::Vector3d* before, int rows);
    void end_landmark() { ++num_landmarks_; }

    // Returns the scale, at least 1.
    double scale(int num_parameters) const;

private:
    double repetition() const;

    double huber_;
    double squares_ = 0.0;     // sum of |psi|^2
    double divergence_ = 0.0;  // sum of div psi
    double num_rows_ = 0.0;
    double products_ = 0.0;
    double pair_squares_ = 0.0;
    double num_pairs_ = 0.0;
    double num_landmarks_ = 0.0;
};

}  // namespace divemesh::optimisation
