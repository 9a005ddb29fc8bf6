#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "worker/odometry/with_depth_at_both_times.hpp"
#include "worker/types/feature.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::odometry {

// Recognises a rig that stands still. Each frame is compared with an anchor, the first frame of the
// rest, not with the frame before: however slowly the rig moves, its distance from the anchor grows
// until it shows. So a rest hides no more motion than the noise of a single pose.
class RestDetector {
public:
    explicit RestDetector(const types::RectifiedRig& rig) : rig_(rig) {}

    // Takes in the static features of a frame and its pose. Returns the pose of the rest,
    // T_world_cam of the anchor, if the rig has stood still for at least a second; nullopt
    // otherwise.
    std::optional<Eigen::Isometry3d> watch(std::int64_t now_ns,
                                           const types::Features& features,
                                           const Eigen::Isometry3d& T_world_cam);
    // Begins anew with the next frame: the map has changed, or sensors say that the rig moves.
    void restart() { anchor_.clear(); }

    // Returns when the rest began. Valid while watch() returns a pose.
    std::int64_t began_ns() const { return anchor_ns_; }

private:
    bool stands_still(const types::Features& features) const;

    types::RectifiedRig rig_;
    types::Features anchor_;
    std::int64_t anchor_ns_ = 0;
    Eigen::Isometry3d T_world_anchor_ = Eigen::Isometry3d::Identity();
};

}  // namespace divemesh::odometry
