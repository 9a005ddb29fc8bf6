#pragma once

#include <Eigen/Geometry>
#include <ceres/sized_cost_function.h>

#include "worker/camera/rectified_lens.hpp"
#include "worker/optimisation/residuals/stereo_reprojection.hpp"

namespace divemesh::calibration {

// StereoReprojection through lenses that differ from the calibration used for rectification:
//
//     r = r_stereo + G c / sigma      c: change of the left lens, then of the right one
//
// G, 3 x 10, is the derivative of this observation's (u, v, disparity) with respect to c. Blocks:
// q_world_imu (x y z w), p_world_imu (m), p_world (m), c.
struct LensReprojection {
    static constexpr int kNumChanges = 2 * types::LensChange::kSize;
    using Shift = Eigen::Matrix<double, 3, kNumChanges>;

    optimisation::StereoReprojection stereo;
    Shift shift_px;

    static ceres::CostFunction* create(const LensReprojection& reprojection);
};

// The cost function of LensReprojection with analytic derivatives.
class LensReprojectionCost
    : public ceres::SizedCostFunction<3, 4, 3, 3, LensReprojection::kNumChanges> {
public:
    explicit LensReprojectionCost(const LensReprojection& reprojection)
        : stereo_(reprojection.stereo),
          jacobian_of_change_(reprojection.stereo.sigma_px.cwiseInverse().asDiagonal() *
                              reprojection.shift_px) {
        if (reprojection.stereo.measured_px.z() <= 0.0) jacobian_of_change_.row(2).setZero();
    }

    bool Evaluate(double const* const* blocks, double* r, double** jacobians) const override {
        if (!stereo_.Evaluate(blocks, r, jacobians)) return false;
        Eigen::Map<Eigen::Vector3d>{r} +=
            jacobian_of_change_ *
            Eigen::Map<const Eigen::Matrix<double, LensReprojection::kNumChanges, 1>>(blocks[3]);
        if (jacobians && jacobians[3])
            Eigen::Map<Eigen::Matrix<double, 3, LensReprojection::kNumChanges, Eigen::RowMajor>>{
                jacobians[3]} = jacobian_of_change_;
        return true;
    }

private:
    optimisation::StereoReprojectionCost stereo_;
    LensReprojection::Shift jacobian_of_change_;
};

inline ceres::CostFunction* LensReprojection::create(const LensReprojection& reprojection) {
    return new LensReprojectionCost(reprojection);
}

}  // namespace divemesh::calibration
