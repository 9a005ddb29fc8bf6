#pragma once

#include <Eigen/Geometry>
#include <ceres/sized_cost_function.h>

#include "worker/camera/rectified_lens.hpp"
#include "worker/optimisation/residuals/stereo_reprojection.hpp"

namespace divemesh::calibration {

// StereoReprojection through lenses that differ from the calibration used for rectification, and
// through a rolling shutter:
//
//     r = r_stereo + (G c + h t) / sigma      c: change of the left lens, then of the right one
//                                             t: readout time, s
//
// G, 3 x 10, and h are the derivatives of this observation's (u, v, disparity) with respect to c
// and t. Blocks: q_world_imu (x y z w), p_world_imu (m), p_world (m), c, t.
struct LensReprojection {
    static constexpr int kNumChanges = 2 * types::LensChange::kSize;
    using Shift = Eigen::Matrix<double, 3, kNumChanges>;

    optimisation::StereoReprojection stereo;
    Shift shift_px;
    Eigen::Vector3d by_readout_px_s = Eigen::Vector3d::Zero();

    static ceres::CostFunction* create(const LensReprojection& reprojection);
};

// The cost function of LensReprojection with analytic derivatives.
class LensReprojectionCost
    : public ceres::SizedCostFunction<3, 4, 3, 3, LensReprojection::kNumChanges, 1> {
public:
    explicit LensReprojectionCost(const LensReprojection& reprojection)
        : stereo_(reprojection.stereo),
          jacobian_of_change_(reprojection.stereo.sigma_px.cwiseInverse().asDiagonal() *
                              reprojection.shift_px),
          jacobian_of_readout_(
              reprojection.by_readout_px_s.cwiseQuotient(reprojection.stereo.sigma_px)) {
        if (reprojection.stereo.measured_px.z() > 0.0) return;
        jacobian_of_change_.row(2).setZero();
        jacobian_of_readout_.z() = 0.0;
    }

    bool Evaluate(double const* const* blocks, double* r, double** jacobians) const override {
        if (!stereo_.Evaluate(blocks, r, jacobians)) return false;
        Eigen::Map<Eigen::Vector3d>{r} +=
            jacobian_of_change_ *
                Eigen::Map<const Eigen::Matrix<double, LensReprojection::kNumChanges, 1>>(
                    blocks[3]) +
            jacobian_of_readout_ * *blocks[4];
        if (jacobians && jacobians[3])
            Eigen::Map<Eigen::Matrix<double, 3, LensReprojection::kNumChanges, Eigen::RowMajor>>{
                jacobians[3]} = jacobian_of_change_;
        if (jacobians && jacobians[4])
            Eigen::Map<Eigen::Vector3d>{jacobians[4]} = jacobian_of_readout_;
        return true;
    }

private:
    optimisation::StereoReprojectionCost stereo_;
    LensReprojection::Shift jacobian_of_change_;
    Eigen::Vector3d jacobian_of_readout_;
};

inline ceres::CostFunction* LensReprojection::create(const LensReprojection& reprojection) {
    return new LensReprojectionCost(reprojection);
}

}  // namespace divemesh::calibration
