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

// The last keyframe in full, and what each is recognised by: when the scene was out of sight, and
// what comes into sight again overlaps with it, the dive goes on where it is.
class Relocaliser {
public:
    // Remembers nothing unless `used`.
    Relocaliser(const types::RectifiedRig& rig, bool used, int num_disparities_px);

    // A frame was not constrained by vision.
    void mark_lost() { lost_ = true; }

    // A frame about to be kept. After sight was lost: features of the last keyframe that it shows
    // join `features` under their ids, and `motion` is put right.
    void relocalise(const types::RectifiedFrame& frame,
                    std::uint64_t seed,
                    types::Features& features,
                    odometry::MotionModel& motion);
    // It was kept, at this pose. What it is recognised by; nothing: no loop is looked for.
    std::optional<features::DescribedKeypoints> keep(const types::RectifiedFrame& frame,
                                                     const types::Features& features,
                                                     const Eigen::Isometry3d& T_world_cam);

private:
    struct Known {
        Eigen::Isometry3d T_current_reference = Eigen::Isometry3d::Identity();
        types::Features features;  // of the last keyframe, by their ids, where they are now
    };
    std::optional<Known> match_last_keyframe(const types::RectifiedFrame& frame,
                                             std::uint64_t seed) const;

    types::RectifiedRig rig_;
    bool used_;
    int num_disparities_px_;
    bool lost_ = false;
    features::DescribedKeypoints view_;       // of the frame about to be kept
    features::DescribedKeypoints last_view_;  // of the last keyframe, as what follows
    cv::Mat last_left_;
    types::Features last_features_;
    Eigen::Isometry3d T_world_last_ = Eigen::Isometry3d::Identity();
};

}  // namespace divemesh::loops
