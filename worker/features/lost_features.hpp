#pragma once

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "worker/features/reference_patch.hpp"
#include "worker/types/feature.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::features {

// Features that the tracking lost (a particle passed, a caustic flared up, the picture was blurred)
// are looked for again where the camera's motion lets expect them, for some frames.
class LostFeatures {
public:
    struct Found {
        types::Feature feature;  // with the disparity that is to be expected
        ReferencePatch look;
    };

    explicit LostFeatures(const types::RectifiedRig& rig) : rig_(rig) {}

    // `feature` as the frame before had it, with depth; `look`: how it looks.
    void lose(const types::Feature& feature, const ReferencePatch& look);
    // What has come back in the next picture, by id, once its motion is known.
    std::vector<Found> find(const cv::Mat& image, const Eigen::Isometry3d& T_current_previous);

private:
    struct Lost {
        std::int64_t id = 0;
        Eigen::Vector3d p_cam;  // as the camera stands now
        int num_frames = 0;     // since it was seen
        ReferencePatch look;
    };

    types::RectifiedRig rig_;
    std::vector<Lost> lost_;
};

}  // namespace divemesh::features
