#pragma once

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "worker/features/reference_patch.hpp"
#include "worker/types/feature.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::features {

// Features that tracking lost (a particle passed, a caustic flared up, the image was blurred). For
// some frames they are searched for again at the position predicted by the camera's motion.
class LostFeatures {
public:
    struct Found {
        types::Feature feature;  // with the predicted disparity
        ReferencePatch reference;
    };

    explicit LostFeatures(const types::RectifiedRig& rig) : rig_(rig) {}

    // Adds a lost feature, as the previous frame had it, with depth; `reference` is its reference
    // patch.
    void lose(const types::Feature& feature, const ReferencePatch& reference);
    // Forgets the features lost since the last call of find().
    void forget_newest();
    // Returns the features found again in the current image, by id, once its motion is known.
    std::vector<Found> find(const cv::Mat& image, const Eigen::Isometry3d& T_current_previous);

private:
    struct Lost {
        std::int64_t id = 0;
        Eigen::Vector3d p_cam;  // in the current camera frame
        int num_frames = 0;     // since it was last seen
        ReferencePatch reference;
    };

    types::RectifiedRig rig_;
    std::vector<Lost> lost_;
};

}  // namespace divemesh::features
