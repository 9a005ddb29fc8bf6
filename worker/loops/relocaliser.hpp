#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <unordered_set>

#include "worker/features/described_keypoints.hpp"
#include "worker/loops/register_wide_baseline.hpp"
#include "worker/loops/sift_keypoints.hpp"
#include "worker/odometry/motion_model.hpp"
#include "worker/odometry/with_depth_at_both_times.hpp"
#include "worker/types/feature.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::loops {

// The memory of the previous frame and of the last keyframes. Where tracking fails, the current
// frame is registered to them by descriptors, without a prediction.
class Relocaliser {
public:
    // Returns keypoints for loop closure only if `close_loops`.
    Relocaliser(const types::RectifiedRig& rig, bool close_loops, int num_disparities_px);

    // Returns T_current_previous, accurate to some pixels; nullopt: the images do not overlap
    // enough. `prior` is of T_current_previous.
    std::optional<Eigen::Isometry3d> register_to_previous(const types::RectifiedFrame& frame,
                                                          const MotionPrior& prior,
                                                          std::uint64_t seed);

    // A frame recognised by a keyframe that it overlaps.
    struct Recognised {
        Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
        Eigen::Isometry3d T_world_keyframe = Eigen::Isometry3d::Identity();
        types::Features in_keyframe;  // with their ids, as the keyframe had them
        types::Features features;     // the same at current positions
    };
    // Returns the frame as recognised by the newest of the last keyframes that it overlaps; nullopt
    // if it overlaps none. The pose as predicted is tried first.
    std::optional<Recognised> recognise(const types::RectifiedFrame& frame,
                                        const Eigen::Isometry3d& predicted_T_world_cam,
                                        std::uint64_t seed);

    // Marks that a frame was not constrained by vision.
    void mark_lost() { lost_ = true; }
    // Marks that a frame shows the scene from before the loss.
    void mark_found() { lost_ = false; }
    // Called for a frame that is about to become a keyframe. After a loss, features of the last
    // keyframes that it shows are added to `features` with their ids, and `motion` is corrected;
    // then it returns true.
    bool relocalise(const types::RectifiedFrame& frame,
                    std::uint64_t seed,
                    types::Features& features,
                    odometry::MotionModel& motion);

    // Stores the frame as a keyframe with this pose. Returns its keypoints; nullopt if loops are
    // not searched for.
    std::optional<features::DescribedKeypoints> keep(const types::RectifiedFrame& frame,
                                                     const types::Features& features,
                                                     const Eigen::Isometry3d& T_world_cam);
    // Adds the features that follow the scene's motion in a frame with this pose. Other features of
    // a keyframe that are in sight may belong to a dynamic object, so no frame is recognised by
    // them.
    void confirm(const odometry::PointPairs& inliers, const Eigen::Isometry3d& T_world_cam);
    // Stores the frame as the previous one.
    void pass(const types::RectifiedFrame& frame);

private:
    using Keypoints = std::shared_ptr<const SiftKeypoints>;  // nullptr: not needed so far
    struct View {
        types::RectifiedFrame frame;
        Keypoints keypoints;
    };
    struct KeptKeyframe {
        View view;
        types::Features features;                    // those with depth
        std::unordered_set<std::int64_t> confirmed;  // of these, in that frame or a later one
        std::unordered_set<std::int64_t> missed;     // in sight of such a frame, but not followed
        Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
    };
    const SiftKeypoints& described(View& view) const;
    View& current(const types::RectifiedFrame& frame);
    std::optional<Recognised> recognise_by(KeptKeyframe& keyframe,
                                           const types::RectifiedFrame& frame,
                                           const Eigen::Isometry3d& predicted_T_world_cam,
                                           std::uint64_t seed);
    std::optional<Recognised> recognise_from(const KeptKeyframe& keyframe,
                                             const types::RectifiedFrame& frame,
                                             Eigen::Isometry3d T_current_keyframe) const;
    bool contradicts(const KeptKeyframe& keyframe,
                     const Eigen::Isometry3d& T_current_keyframe,
                     const types::Features& found) const;

    types::RectifiedRig rig_;
    bool close_loops_;
    int num_disparities_px_;
    bool lost_ = false;
    std::optional<View> current_;
    std::optional<View> previous_;
    std::deque<KeptKeyframe> keyframes_;  // newest first
};

}  // namespace divemesh::loops
