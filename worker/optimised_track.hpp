#pragma once

#include <vector>

#include "worker/estimation/refined_calibration.hpp"
#include "worker/geometry/rectified_rig.hpp"
#include "worker/keyframe.hpp"
#include "worker/loop_statistics.hpp"
#include "worker/path_uncertainty.hpp"
#include "worker/pose_covariance.hpp"
#include "worker/recording.hpp"

namespace divemesh::worker {

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

}  // namespace divemesh::worker
