#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "worker/odometry/predict_orientation.hpp"
#include "worker/odometry/refined_pose.hpp"
#include "worker/odometry/register_points.hpp"
#include "worker/types/track.hpp"

namespace divemesh::odometry {

// The statistics of the tracking, accumulated over the frames.
class TrackSummary {
public:
    void add_frame(const types::Features& features,
                   const Registration& motion,
                   const MotionGuess& guess);
    // Counts the first frame, which has no motion.
    void add_first_frame() {
        ++num_frames_;
        ++num_tracked_;
    }

    // Counts how the solver of step 6 ended. Returns its motion, T_current_previous.
    Eigen::Isometry3d counted(const RefinedPose& pose) {
        pose_solver_.add(pose.outcome);
        return pose.T_current_previous;
    }

    // Returns the statistics without skipped frames and the dense search, which are counted
    // elsewhere.
    types::TrackStatistics statistics() const;

private:
    void follow(const types::Features& features);

    std::int64_t num_frames_ = 0;
    std::int64_t num_tracked_ = 0;
    std::int64_t num_degenerate_ = 0;
    std::int64_t num_features_ = 0;
    std::int64_t num_pairs_ = 0;
    std::int64_t num_inliers_ = 0;
    types::SolverTally pose_solver_;
    double squared_disagreement_ = 0.0;
    std::int64_t num_disagreements_ = 0;
    std::vector<double> scales_;
    std::vector<double> depths_m_;               // median of each frame
    std::vector<double> lives_frames_;           // of the tracks that ended
    std::unordered_map<std::int64_t, int> age_;  // of the current tracks
};

}  // namespace divemesh::odometry
