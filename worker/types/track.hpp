#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "schemas/finding.hpp"
#include "worker/types/breaks.hpp"
#include "worker/types/imu_alignment.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/landmark.hpp"
#include "worker/types/motion_sigma.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/rectified_rig.hpp"
#include "worker/types/rest.hpp"
#include "worker/types/search_outcome.hpp"
#include "worker/types/sensors_left_out.hpp"
#include "worker/types/solver_outcome.hpp"

namespace divemesh::types {

// Statistics of the tracking.
struct TrackStatistics {
    std::int64_t num_frames = 0;             // decoded
    std::int64_t num_skipped_frames = 0;     // did not decode
    std::int64_t num_frames_tracked = 0;     // constrained by vision
    std::int64_t num_degenerate_frames = 0;  // too few or too distant features, or all on one line
    double mean_tracked_features = 0.0;
    double inlier_share = 0.0;                 // inliers after RANSAC / tracked features
    double imu_vision_disagreement_deg = 0.0;  // gyro against vision, RMS per frame; 0: no IMU
    double horn_scale_median = 1.0;            // Horn's s, estimated and reported, never applied
    double median_depth_m = 0.0;               // of the features
    double median_track_life_frames = 0.0;
    SolverTally pose_solver;    // outcomes of step 6
    SolverTally window_solver;  // sliding window; the next keyframe solves it again
    SearchStatistics dense;     // frames whose depth is in the store
};

// What measured a frame's motion from the frame before.
enum class MotionSource : std::uint8_t { Nothing, Imu, Vision };

// Features of a frame after tracking; they show why the next motion was lost.
struct FrameFeatures {
    std::int32_t num_features = 0;    // all
    std::int32_t num_with_depth = 0;  // found in the right image too
};

// Pairs in a row that could not be used: their images are missing, broken or repeated.
struct UnusablePairs {
    std::int64_t first = 0;  // its number among all pairs
    std::int64_t num = 0;
    std::int64_t next_frame = 0;  // the usable one after them, numbered among the usable ones
    double duration_s = 0.0;      // from the usable one before them to the one after
};

// The result of steps 1 to 6 over all frames.
struct Track {
    RectifiedRig rig;
    Trajectory causal;                    // every frame, from data up to its time
    Trajectory odometry;                  // chained frame-to-frame motion: drifts but never jumps
    std::vector<MotionSigma> sigmas;      // of the odometry's motion to every frame; at rest 0
    std::vector<MotionSource> motions;    // of every frame; of the first: Nothing
    Breaks breaks_ns;                     // the frames after the first with nothing measured
    std::vector<FrameFeatures> features;  // of every frame
    std::vector<UnusablePairs> unusable;  // ascending
    std::vector<Rest> rests;              // ascending; `odometry` holds the motion within them
    std::vector<Keyframe> keyframes;
    std::vector<Keyframe> mapped;  // frames with depth in the store: keyframes and some between
    std::vector<Landmark> landmarks;
    ImuAlignment imu_alignment;     // as estimated during tracking
    SensorsLeftOut left_out;        // the sensors' data that the later steps must not use
    double pressure_error_m = 0.0;  // of changes over five seconds, RMS against vision
    std::vector<Finding> findings;
    std::vector<Finding> image_findings;  // of the dive, made while its images were read
    TrackStatistics statistics;
    std::int32_t reduction = 1;  // the images were read at 1 / reduction of their size
};

// Returns the number of frames whose motion vision measured.
inline std::ptrdiff_t num_by_vision(const Track& track) {
    return std::ranges::count(track.motions, MotionSource::Vision);
}

}  // namespace divemesh::types
