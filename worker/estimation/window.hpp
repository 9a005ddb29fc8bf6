#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "worker/estimation/adjustment.hpp"
#include "worker/estimation/gyroscope_integral.hpp"
#include "worker/reconstruct.hpp"
#include "worker/steps/feature.hpp"
#include "worker/steps/with_depth_at_both_times.hpp"

namespace divemesh::worker {

// The last keyframes and what they saw, adjusted together: poses, landmarks and the gyroscope's
// bias all free, so that a noisy depth is never taken for the truth. Older keyframes that see the
// same landmarks hold the window in place.
class Window {
public:
    Window(const RectifiedRig& rig, double gyroscope_random_walk)
        : rig_(rig), gyroscope_random_walk_(gyroscope_random_walk) {}

    // `turn`: the gyroscope's word since the keyframe before.
    void add_keyframe(const Keyframe& keyframe,
                      const Features& features,
                      const std::optional<GyroscopeIntegral>& turn);
    void adjust();

    // Where a landmark is known, it takes the place of the point measured at t-1.
    void use_landmarks(const Eigen::Isometry3d& T_world_previous, PointPairs& pairs) const;

    bool empty() const { return keyframes_.empty(); }
    const Eigen::Isometry3d& T_world_cam() const { return keyframes_.back().T_world_cam; }
    const Eigen::Vector3d& gyroscope_bias() const { return entries_.back().state.gyroscope_bias; }
    const std::vector<Keyframe>& keyframes() const { return keyframes_; }
    std::vector<Landmark> landmarks() const;  // seen by two keyframes or more

private:
    struct Entry {
        BodyState state;
        std::optional<GyroscopeIntegral> turn;  // since the keyframe before
        std::vector<std::size_t> landmarks;     // seen here
    };
    std::size_t landmark_of(const Feature& feature, const Keyframe& keyframe);
    void add_landmarks(Adjustment& adjustment, std::size_t first, std::size_t first_free);
    void add_turns(Adjustment& adjustment, std::size_t first_free);
    void drop_outliers(std::size_t first_free);

    RectifiedRig rig_;
    double gyroscope_random_walk_;
    std::vector<Keyframe> keyframes_;
    std::vector<Entry> entries_;
    std::vector<Landmark> landmarks_;
    std::unordered_map<std::int64_t, std::size_t> landmark_of_feature_;
};

}  // namespace divemesh::worker
