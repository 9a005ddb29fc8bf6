#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <deque>
#include <optional>

#include "worker/odometry/with_depth_at_both_times.hpp"
#include "worker/types/feature.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::odometry {

// Returns the median distance between the pixels of pairs, 0 without pairs.
double median_shift_px(const PointPairs& pairs);

// Recognises a rig that stands still or hardly moves. Each frame is compared with an anchor, the
// first frame of the rest, not with the frame before: however slowly the rig moves, its distance
// from the anchor grows until it shows. So a rest hides no more motion than the noise of a single
// pose. Features that appear during the rest join the anchor, so that it outlasts a person who
// walks past; each time that all features have changed, it can hide as much again. Features that
// fish drag along or that light moves count neither for a motion nor against a rest. Where many are
// moved together, the motions scatter about their trend; a motion counts only if it exceeds that.
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
    // Takes in features as they were in the last frame, before watch() takes in the next: those
    // that are new there join the anchor if the rig had not moved, so that it outlasts what hides
    // all others within a frame.
    void join(const types::Features& in_last_frame);
    // Takes in a frame in which nothing was seen.
    void pass_frame() {
        at_rest_ = false;
        T_anchor_cam_.reset();
    }
    // Begins anew with the next frame: sensors say that the rig moves.
    void restart() {
        anchor_.clear();
        motions_.clear();
        hardly_moves_ = false;
        pass_frame();
    }
    // Takes in that the last frame has another pose in the map: it was adjusted, or the place was
    // recognised. A rest goes on there.
    void correct(const Eigen::Isometry3d& T_world_cam);

    // Returns true if the last frame's image had hardly moved since an earlier frame, however
    // recent.
    bool hardly_moves() const { return hardly_moves_; }
    // Returns true if watch() returned a pose for the last frame.
    bool at_rest() const { return at_rest_; }
    // Returns when the rest began. Valid while watch() returns a pose.
    std::int64_t began_ns() const { return anchor_ns_; }
    // Return the standard deviations of the pose against the anchor's, likewise: the largest along
    // or about any axis.
    double sigma_m() const { return sigma_m_; }
    double sigma_rad() const { return sigma_rad_; }
    // Returns the camera's rotation since then, likewise.
    Eigen::Quaterniond q_anchor_cam() const { return Eigen::Quaterniond(T_anchor_cam_->linear()); }

private:
    using Vector6d = Eigen::Matrix<double, 6, 1>;
    using Matrix6d = Eigen::Matrix<double, 6, 6>;
    struct Motion {
        std::int64_t time_ns = 0;
        Vector6d since_anchor;  // rotation vector, rad, then translation, m
    };

    bool hardly_moved(const PointPairs& pairs) const;
    PointPairs in_place(const PointPairs& pairs) const;
    PointPairs agreeing(const PointPairs& pairs) const;
    double scatter_of_motions(std::int64_t until_ns, const Matrix6d& covariance) const;
    std::optional<Eigen::Isometry3d> significant_motion(std::int64_t now_ns,
                                                        const PointPairs& pairs);

    types::RectifiedRig rig_;
    types::Features anchor_;
    std::int64_t anchor_ns_ = 0;
    std::int64_t last_ns_ = 0;
    std::deque<Motion> motions_;  // the latest
    bool hardly_moves_ = false;
    Eigen::Isometry3d T_world_anchor_ = Eigen::Isometry3d::Identity();
    bool at_rest_ = false;
    std::optional<Eigen::Isometry3d> T_anchor_cam_;  // of the last frame, if it hardly moved
    double sigma_m_ = 0.0;
    double sigma_rad_ = 0.0;
};

}  // namespace divemesh::odometry
