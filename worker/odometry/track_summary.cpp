#include "worker/odometry/track_summary.hpp"

#include <algorithm>
#include <cmath>

#include "worker/base/angle.hpp"
#include "worker/stats/median.hpp"
#include "worker/stats/ratio.hpp"

namespace divemesh::odometry {

void TrackSummary::add_frame(const types::Features& features,
                             const Registration& motion,
                             const MotionGuess& guess) {
    ++num_frames_;
    num_features_ += static_cast<std::int64_t>(features.size());
    num_pairs_ += static_cast<std::int64_t>(motion.num_pairs);
    follow(features);
    if (motion.degenerate) ++num_degenerate_;
    if (!motion.found) return;
    ++num_tracked_;
    num_inliers_ += static_cast<std::int64_t>(motion.inliers.size());
    scales_.push_back(motion.scale);
    std::vector<double> depths;
    for (const PointPair& pair : motion.inliers) depths.push_back(pair.p_current.z());
    depths_m_.push_back(stats::upper_median(std::move(depths)));
    if (!guess.rotation) return;
    squared_disagreement_ += guess.disagreement_rad * guess.disagreement_rad;
    ++num_disagreements_;
}

void TrackSummary::follow(const types::Features& features) {
    std::unordered_map<std::int64_t, int> alive;
    for (const types::Feature& feature : features) {
        const auto before = age_.find(feature.id);
        alive[feature.id] = before == age_.end() ? 1 : before->second + 1;
        if (before != age_.end()) age_.erase(before);
    }
    for (const auto& [id, frames] : age_) lives_frames_.push_back(frames);
    age_ = std::move(alive);
}

types::TrackStatistics TrackSummary::statistics() const {
    types::TrackStatistics result;
    result.num_frames = num_frames_;
    result.num_frames_tracked = num_tracked_;
    result.num_degenerate_frames = num_degenerate_;
    result.mean_tracked_features =
        stats::ratio(num_features_, std::max<std::int64_t>(0, num_frames_ - 1));
    result.inlier_share = stats::ratio(num_inliers_, num_pairs_);
    result.imu_vision_disagreement_deg =
        std::sqrt(stats::ratio(squared_disagreement_, num_disagreements_)) * base::kDegPerRad;
    result.horn_scale_median = scales_.empty() ? 1.0 : stats::upper_median(scales_);
    result.median_depth_m = stats::upper_median(depths_m_);
    std::vector<double> lives = lives_frames_;
    for (const auto& [id, frames] : age_) lives.push_back(frames);
    result.median_track_life_frames = stats::upper_median(std::move(lives));
    result.pose_solver = pose_solver_;
    return result;
}

}  // namespace divemesh::odometry
