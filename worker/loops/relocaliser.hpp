#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "worker/features/described_keypoints.hpp"
#include "worker/loops/search_by_projection.hpp"
#include "worker/odometry/motion_model.hpp"
#include "worker/types/feature.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::loops {

// The memory of the last keyframe and its keypoints. If the scene was lost and comes back
// overlapping that keyframe, tracking continues from there.
class Relocaliser {
public:
    // Stores keyframes only if `used`.
    Relocaliser(const types::RectifiedRig& rig, bool used, int num_disparities_px);

    // Marks that a frame was not constrained by vision.
    void mark_lost() { lost_ = true; }

    // Called for a frame that is about to become a keyframe. After a loss, features of the last
    // keyframe that it shows are added to `features` with their ids, and `motion` is corrected.
    void relocalise(const types::RectifiedFrame& frame,
                    std::uint64_t seed,
                    types::Features& features,
                    odometry::MotionModel& motion);
    // Stores the frame as a keyframe with this pose. Returns its keypoints; nullopt if loops are
    // not searched for.
    std::optional<features::DescribedKeypoints> keep(const types::RectifiedFrame& frame,
                                                     const types::Features& features,
                                                     const Eigen::Isometry3d& T_world_cam);

private:
    struct Known {
        Eigen::Isometry3d T_current_reference = Eigen::Isometry3d::Identity();
        types::Features features;  // of the last keyframe, with their ids, at current positions
    };
    std::optional<Known> match_last_keyframe(const types::RectifiedFrame& frame,
                                             std::uint64_t seed) const;

    types::RectifiedRig rig_;
    bool used_;
    int num_disparities_px_;
    bool lost_ = false;
    features::DescribedKeypoints keypoints_;       // of the frame about to become a keyframe
    features::DescribedKeypoints last_keypoints_;  // of the last keyframe, as are the members below
    cv::Mat last_left_;
    types::Features last_features_;
    Eigen::Isometry3d T_world_last_ = Eigen::Isometry3d::Identity();
};

}  // namespace divemesh::loops
