#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "worker/loops/sift_keypoints.hpp"
#include "worker/types/known_rotation.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::loops {

// A motion as predicted before the images are compared.
struct MotionPrior {
    std::optional<Eigen::Isometry3d> T_b_a;        // predicted
    std::optional<types::KnownRotation> rotation;  // R_b_a, measured by the inertial sensors
};

// Returns T_b_a on which the keypoints of two frames agree, in both images of each, accurate to
// some pixels; nullopt: the frames do not show the same place. The agreeing keypoints must be
// spread over the image. Fewer of them are enough where the motion fits the prior. If enough
// support the predicted motion, it is taken although more may support another: something large
// passes in front of the camera.
//
// RANSAC over three pairs: Horn's motion, refined by the pairs' covariances, as the depth of far
// points is too noisy for it. The best motion is refined over its inliers.
std::optional<Eigen::Isometry3d> register_wide_baseline(const types::RectifiedRig& rig,
                                                        const SiftKeypoints& a,
                                                        const SiftKeypoints& b,
                                                        const MotionPrior& prior,
                                                        std::uint64_t seed);

}  // namespace divemesh::loops
