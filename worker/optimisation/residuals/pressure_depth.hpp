#pragma once

#include <ceres/autodiff_cost_function.h>

namespace divemesh::optimisation {

// The depth of the body below the surface from its pressure:
//
//     r = (offset + scale down^T p - depth) / sigma
//
// Blocks: p_world_imu (m), gravity_direction_world (unit vector), offset (m): the depth of the
// world's origin, scale: of the sensor's depths.
struct PressureDepth {
    double depth_m = 0.0;
    double sigma_m = 0.0;

    template <typename T>
    bool operator()(const T* const p_world_imu,
                    const T* const gravity_direction_world,
                    const T* const offset_m,
                    const T* const scale,
                    T* residual) const {
        T depth = offset_m[0];
        for (int i = 0; i < 3; ++i) depth += scale[0] * gravity_direction_world[i] * p_world_imu[i];
        residual[0] = (depth - T(depth_m)) / T(sigma_m);
        return true;
    }

    static ceres::CostFunction* create(const PressureDepth& pressure) {
        return new ceres::AutoDiffCostFunction<PressureDepth, 1, 3, 3, 1, 1>(
            new PressureDepth(pressure));
    }
};

}  // namespace divemesh::optimisation
