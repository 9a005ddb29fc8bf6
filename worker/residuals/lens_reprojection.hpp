#pragma once

#include <Eigen/Geometry>
#include <ceres/autodiff_cost_function.h>

#include "worker/geometry/rectified_lens.hpp"
#include "worker/residuals/stereo_reprojection.hpp"

namespace divemesh::worker {

// StereoReprojection through lenses that are not quite what rectification took them for:
//
//     r = r_stereo + G c / sigma      c: change of the left lens, then of the right one
//
// G, 3 x 10, is how (u, v, disparity) of this observation move with c. Blocks: q_world_imu
// (x y z w), p_world_imu (m), p_world (m), c.
struct LensReprojection {
    static constexpr int kNumChanges = 2 * LensChange::kSize;
    using Shift = Eigen::Matrix<double, 3, kNumChanges>;

    StereoReprojection stereo;
    Shift shift_px;

    template <typename T>
    bool operator()(const T* const q_world_imu,
                    const T* const p_world_imu,
                    const T* const p_world,
                    const T* const change,
                    T* residual) const {
        if (!stereo(q_world_imu, p_world_imu, p_world, residual)) return false;
        const int rows = stereo.measured_px.z() > 0.0 ? 3 : 2;
        for (int row = 0; row < rows; ++row)
            for (int i = 0; i < kNumChanges; ++i)
                residual[row] += T(shift_px(row, i) / stereo.sigma_px[row]) * change[i];
        return true;
    }

    static ceres::CostFunction* create(const LensReprojection& reprojection) {
        return new ceres::AutoDiffCostFunction<LensReprojection, 3, 4, 3, 3, kNumChanges>(
            new LensReprojection(reprojection));
    }
};

}  // namespace divemesh::worker
