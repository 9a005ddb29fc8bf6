#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>

#include "worker/odometry/with_depth_at_both_times.hpp"
#include "worker/types/feature.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::odometry {

// Recognises a rig that stands still or hardly moves. Each frame is compared with an anchor, the
// first frame of the rest, not with the frame before: however slowly the rig moves, its distance
// from the anchor grows until it shows. So a rest hides no more motion than the noise of a single
// pose. Features that appear during the rest join the anchor, so that it outlasts a person who
// walks past; each time that all features have changed, it can hide as much again.
class RestDetector {
public:
    explicit RestDetector(const types::RectifiedRig& rig) : rig_(rig) {}

    // Tells what watch() is given. At rest most static features keep their places. If fish swim
    // before the camera, a part of all features does; then sensors have to say that the rig rests.
    enum class Seen { StaticFeatures, AllFeaturesAtRest };

    // Takes in the features of a frame and its pose. Returns T_world_cam of a rig whose image has
    // not moved by a pixel for at least a second: the anchor's pose, or, if the motion since the
    // anchor is significant, that motion by vision alone. nullopt: the rig moves.
    std::optional<Eigen::Isometry3d> watch(std::int64_t now_ns,
                                           const types::Features& features,
                                           const Eigen::Isometry3d& T_world_cam,
                                           Seen seen = Seen::StaticFeatures);
    // Begins anew with the next frame: the map has changed, or sensors say that the rig moves.
    void restart() {
        anchor_.clear();
        hardly_moves_ = false;
    }

    // Returns true if the last frame's image had hardly moved since an earlier frame, however
    // recent.
    bool hardly_moves() const { return hardly_moves_; }
    // Returns when the rest began. Valid while watch() returns a pose.
    std::int64_t began_ns() const { return anchor_ns_; }
    // Return the standard deviations of the pose against the anchor's, likewise: the largest along
    // or about any axis.
    double sigma_m() const { return sigma_m_; }
    double sigma_rad() const { return sigma_rad_; }
    // Returns the camera's rotation since then, likewise.
    Eigen::Quaterniond q_anchor_cam() const { return Eigen::Quaterniond(T_anchor_cam_.linear()); }

private:
    bool hardly_moved(const PointPairs& pairs) const;
    PointPairs in_place(const PointPairs& pairs) const;
    void join_anchor(const types::Features& features);
    std::optional<Eigen::Isometry3d> significant_motion(const PointPairs& pairs);

    types::RectifiedRig rig_;
    types::Features anchor_;
    std::int64_t anchor_ns_ = 0;
    std::int64_t last_ns_ = 0;
    bool hardly_moves_ = false;
    Eigen::Isometry3d T_world_anchor_ = Eigen::Isometry3d::Identity();
    Eigen::Isometry3d T_anchor_cam_ = Eigen::Isometry3d::Identity();
    double sigma_m_ = 0.0;
    double sigma_rad_ = 0.0;
};

}  // namespace divemesh::odometry
