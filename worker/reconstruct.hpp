#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "schemas/reconstruction_options.hpp"
#include "worker/estimation/imu_alignment.hpp"
#include "worker/estimation/path_uncertainty.hpp"
#include "worker/estimation/pose_covariance.hpp"
#include "worker/estimation/refined_calibration.hpp"
#include "worker/geometry/rectified_rig.hpp"
#include "worker/keyframe.hpp"
#include "worker/keyframe_store.hpp"
#include "worker/observer.hpp"
#include "worker/recording.hpp"
#include "worker/steps/add_points.hpp"
#include "worker/volume/mesh.hpp"
#include "worker/volume/octree_volume.hpp"
#include "worker/volume/simplify_mesh.hpp"

// The method: four stages that together are the paper's eight steps. Each takes plain values and
// gives plain values, so a stage can start from what the one before wrote to disk
// (worker/stage_files.hpp).
namespace divemesh::worker {

// A feature as a keyframe saw it, in the rectified pair.
struct LandmarkObservation {
    std::int32_t keyframe = 0;  // index into Track::keyframes
    float u_px = 0.0F;
    float v_px = 0.0F;
    float disparity_px = 0.0F;  // <= 0: seen by the left camera alone
};

struct Landmark {
    Eigen::Vector3d p_world = Eigen::Vector3d::Zero();
    std::vector<LandmarkObservation> observations;
};

struct TrackStatistics {
    std::int64_t num_frames = 0;             // that decoded
    std::int64_t num_skipped_frames = 0;     // that did not
    std::int64_t num_frames_tracked = 0;     // constrained by vision
    std::int64_t num_degenerate_frames = 0;  // that saw too little, too far or on one line
    double mean_tracked_features = 0.0;
    double inlier_share = 0.0;                 // of the tracked features, after RANSAC
    double imu_vision_disagreement_deg = 0.0;  // RMS per frame of gyro against vision; 0: no IMU
    double horn_scale_median = 1.0;            // Horn's s, estimated and reported, never applied
    double median_depth_m = 0.0;               // of the features
    double median_track_life_frames = 0.0;
    SearchStatistics dense;  // of the frames whose depth is in the store
};

// Steps 1 to 6 over all frames.
struct Track {
    RectifiedRig rig;
    Trajectory causal;    // every frame, as known at its time
    Trajectory odometry;  // the motion from frame to frame, chained: drifts but never jumps
    std::vector<Keyframe> keyframes;
    std::vector<Keyframe> mapped;  // whose depth is in the store: keyframes and some between
    std::vector<Landmark> landmarks;
    ImuAlignment imu_alignment;  // as found on the way
    TrackStatistics statistics;
};

// Two keyframes that may show the same place: looked at, found to by geometry, believed.
struct LoopStatistics {
    std::int64_t num_candidates = 0;
    std::int64_t num_matched = 0;
    std::int64_t num_accepted = 0;
    double largest_correction_m = 0.0;  // by an accepted one, of where the track saw itself
    // What the final trajectory leaves of the accepted ones, RMS: m, and in sigmas per axis.
    double residual_m = 0.0;
    double residual_sigmas = 0.0;
};

struct OptimiseStatistics {
    double reprojection_rms_px = 0.0;
    LoopStatistics loops;
    PathUncertainty path;  // of the final trajectory
};

struct OptimisedTrack {
    Trajectory trajectory;  // every frame, with hindsight
    std::vector<Keyframe> keyframes;
    std::vector<Keyframe> mapped;  // Track::mapped with hindsight
    RectifiedRig rig;              // its body as refined
    RefinedCalibration calibration;
    CovarianceTrack covariances;  // of every frame; empty: not known
    OptimiseStatistics statistics;
};

// The mesh of step 8 as it is given out.
struct Surface {
    Mesh mesh;
    std::optional<SimplificationError> simplification;  // nothing: all triangles stayed
};

Track track(Recording& recording,
            const ReconstructionOptions& options,
            const KeyframeStore& store,
            const ProgressCallback& progress);

OptimisedTrack optimise(const Track& track,
                        const Recording& recording,
                        const ReconstructionOptions& options,
                        const KeyframeStore& store,
                        const ProgressCallback& progress);

// What step 7 makes: where the surface is looked for, and the points that were seen.
struct FusedMap {
    std::unique_ptr<Volume> volume;
    std::unique_ptr<OctreeVolume> cloud;
};

// Voxels and points beyond `options.fusion_memory_bytes` go to the folder `scratch`.
FusedMap fuse(const RectifiedRig& rig,
              const std::vector<Keyframe>& frames,
              double median_depth_m,
              const ReconstructionOptions& options,
              const KeyframeStore& store,
              const std::filesystem::path& scratch,
              const ProgressCallback& progress);

Mesh mesh(const Volume& volume,
          const ReconstructionOptions& options,
          const ProgressCallback& progress);

}  // namespace divemesh::worker
