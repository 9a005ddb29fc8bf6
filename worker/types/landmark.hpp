#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace divemesh::types {

// A feature observed in a keyframe, in the rectified pair.
struct LandmarkObservation {
    std::int32_t keyframe = 0;  // index into Track::keyframes
    float u_px = 0.0F;
    float v_px = 0.0F;
    float disparity_px = 0.0F;  // <= 0: seen by the left camera alone
};

// Returns (u, v, disparity), what a stereo camera measures of a point.
inline Eigen::Vector3d measurement_px(const LandmarkObservation& seen) {
    return {seen.u_px, seen.v_px, seen.disparity_px};
}

// A point of the scene with all its observations; p_world in m.
struct Landmark {
    Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
    std::vector<LandmarkObservation> observations;
};

}  // namespace divemesh::types
