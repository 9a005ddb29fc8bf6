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

// Step 2: a tracker of salient features from image to image (Kanade-Lucas-Tomasi).
class FeatureTracker {
public:
    // Tracks about `num_features` features at a time.
    FeatureTracker(const types::RectifiedRig& rig, int num_features);

    // Returns `previous`, the features of the previous image, as found in `left`, starting where
    // the expected camera motion predicts them. Their disparities are predicted and still have to
    // be measured. Each pyramid level aligns the patch around a feature with its own gain and bias,
    // as strobes, caustics and haze change the light between frames. The final position is that of
    // the reference patch, warped by the motion since, so that errors do not accumulate (unwarped,
    // a patch slides by up to a pixel while the camera rotates and approaches). If the appearance
    // has changed too much, it is that of the patch in the previous image. A feature is kept only
    // if tracking it back ends where it began.
    types::Features track(const cv::Mat& left,
                          const types::Features& previous,
                          const Eigen::Isometry3d& T_cam_previous);

    // Tracks `previous`, the features given to the last call of track(), once more into the same
    // image, with a motion that is accurate to some pixels. Patches are warped by it in both
    // directions, so that turns, approaches and steps as wide as half the image leave a feature its
    // id and its reference patch. Features without depth are left out.
    types::Features track_again(const types::Features& previous,
                                const Eigen::Isometry3d& T_cam_previous);

    // Returns, once the motion of the last image is known, features lost some images ago that are
    // found again, with their ids, if none of `present` is near. Their disparities are predicted
    // and still have to be measured.
    types::Features find_lost(const Eigen::Isometry3d& T_cam_previous,
                              const types::Features& present);

    // Returns new features with new ids where the last image has none: on a grid, the best corner
    // (Shi and Tomasi) of each cell, off its fixed pattern (RectifiedFrame::fixed_pattern). After
    // track_again() the cells are smaller, as much of what a wide step finds is out of sight after
    // the next.
    types::Features detect(const types::Features& present, const cv::Mat& fixed_pattern = {});

private:
    static constexpr int kNumLevels = 4;
    using Pyramid = std::array<cv::Mat, kNumLevels>;  // each level half as wide as the one before

    // Two features closer than this are treated as one.
    int min_distance_px() const { return std::max(4, cell_px_ / 4); }

    struct Seen {
        Eigen::Vector2d pixel;
        bool matches_reference = false;  // else the previous image
    };
    Eigen::Vector2d track_coarse(const Eigen::Vector2d& from, const Eigen::Vector2d& guess) const;
    // `before` is the feature's patch in the previous image.
    std::optional<Seen> track_warped(const types::Feature& feature,
                                     const Eigen::Isometry3d& T_cam_previous,
                                     const ReferencePatch* reference,
                                     const ReferencePatch& before) const;
    std::optional<Seen> track_fine(const Eigen::Vector2d& from,
                                   const Eigen::Vector2d& near,
                                   const Patch* reference_patch) const;

    types::RectifiedRig rig_;
    int cell_px_ = 0;
    bool wide_ = false;  // the last image was tracked over a wide baseline
    std::int64_t next_id_ = 0;
    Pyramid previous_pyramid_;
    Pyramid current_pyramid_;                                             // of the last image
    std::unordered_map<std::int64_t, ReferencePatch> reference_patches_;  // of the features
    std::unordered_map<std::int64_t, ReferencePatch> previous_patches_;   // as the image before had
    LostFeatures lost_;
    HighPass high_pass_;
    CornerScores corner_scores_;
};

}  // namespace divemesh::features
