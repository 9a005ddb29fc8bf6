#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <unordered_map>

#include "worker/features/align_patch.hpp"
#include "worker/features/corner_scores.hpp"
#include "worker/features/high_pass.hpp"
#include "worker/features/lost_features.hpp"
#include "worker/features/reference_patch.hpp"
#include "worker/types/feature.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::features {

// Step 2: salient features followed from picture to picture (Kanade-Lucas-Tomasi).
class FeatureTracker {
public:
    // About `num_features` features are followed at a time.
    FeatureTracker(const types::RectifiedRig& rig, int num_features);

    // Finds `previous`, features of the picture before, in `left`; the camera's expected motion
    // says where to look. Each pyramid level aligns the patch around a feature with a gain and a
    // bias of its own, so that strobes, caustics and haze may change the light from frame to frame.
    // Its place is then where it looks as it did when first seen, so that errors do not add up from
    // frame to frame, turned and stretched as the motion since lets expect: as it was, a patch
    // slides by up to a pixel while the camera turns and comes nearer. When it has changed too
    // much, its place is where it looks as it did in the picture before. It stays only
    // when tracking it back ends where it began. Its disparity is what the motion lets expect, to
    // be measured.
    types::Features track(const cv::Mat& left,
                          const types::Features& previous,
                          const Eigen::Isometry3d& T_cam_previous);

    // Once the motion of the last picture is known: features that were lost some pictures ago and
    // are seen again, under their ids, where `present` has none near; their disparities are to be
    // measured.
    types::Features find_lost(const Eigen::Isometry3d& T_cam_previous,
                              const types::Features& present);

    // New features with fresh ids where the last picture has none, spread over a grid, best corner
    // (Shi and Tomasi) of each cell.
    types::Features detect(const types::Features& present);

private:
    static constexpr int kNumLevels = 4;
    using Pyramid = std::array<cv::Mat, kNumLevels>;  // each half as wide as the one before

    // Two features nearer than this are one.
    int min_distance_px() const { return std::max(4, cell_px_ / 4); }

    struct Seen {
        Eigen::Vector2d pixel;
        bool matches_reference = false;  // else as in the picture before
    };
    Eigen::Vector2d track_coarse(const Eigen::Vector2d& from, const Eigen::Vector2d& guess) const;
    std::optional<Seen> track_fine(const Eigen::Vector2d& from,
                                   const Eigen::Vector2d& near,
                                   const Patch* reference_patch) const;

    types::RectifiedRig rig_;
    int cell_px_ = 0;
    std::int64_t next_id_ = 0;
    Pyramid previous_pyramid_;
    Pyramid current_pyramid_;                                             // of the last picture
    std::unordered_map<std::int64_t, ReferencePatch> reference_patches_;  // of the features
    LostFeatures lost_;
    HighPass high_pass_;
    CornerScores corner_scores_;
};

}  // namespace divemesh::features
