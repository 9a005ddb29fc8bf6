#include "worker/pipeline/move_to_own_range.hpp"

#include <algorithm>

#include "worker/camera/range_correction.hpp"

namespace divemesh::pipeline {
namespace {

double disparity_px(const types::Track& track,
                    const types::Landmark& landmark,
                    const types::LandmarkObservation& seen) {
    if (seen.disparity_px > 0.0F) return seen.disparity_px;
    const types::Keyframe& keyframe = track.keyframes[static_cast<std::size_t>(seen.keyframe)];
    const double depth_m = (keyframe.T_world_cam.inverse() * landmark.p_world).z();
    return track.rig.disparity_px(std::max(types::RectifiedRig::kMinDepth_m, depth_m));
}

}  // namespace

void move_to_own_range(const types::RangeTable& ranges, types::Track& track) {
    for (types::Landmark& landmark : track.landmarks)
        for (types::LandmarkObservation& seen : landmark.observations) {
            const Eigen::Vector3f moved =
                camera::at_own_range(ranges,
                                     {seen.u_px, seen.v_px, disparity_px(track, landmark, seen)})
                    .cast<float>();
            seen.u_px = moved.x();
            seen.v_px = moved.y();
        }
}

}  // namespace divemesh::pipeline
