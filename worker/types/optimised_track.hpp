#pragma once

#include <vector>

#include "schemas/finding.hpp"
#include "worker/types/breaks.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/loop_statistics.hpp"
#include "worker/types/path_prior.hpp"
#include "worker/types/path_uncertainty.hpp"
#include "worker/types/pose_covariance.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/rectified_rig.hpp"
#include "worker/types/refined_calibration.hpp"
#include "worker/types/solver_outcome.hpp"
#include "worker/types/track_check.hpp"

namespace divemesh::types {

// Statistics of the optimisation.
struct OptimiseStatistics {
    double reprojection_rms_px = 0.0;
    SolverTally pose_graph;         // of the loops
    SolverTally calibration;        // refined
    SolverTally bundle_adjustment;  // of the whole dive; tried again where its result was not taken
    TrackCheck check;               // of the bundle adjustment that was taken, or of the last one
    LoopStatistics loops;
    PathUncertainty path;  // of the final trajectory
};

// The result of the optimisation of a whole dive.
struct OptimisedTrack {
    Trajectory trajectory;  // after optimisation: every frame whose pose was measured
    Breaks breaks_ns;       // of the trajectory
    Trajectory predicted;   // the other frames, by the motion model: nothing measured their poses
    std::vector<Keyframe> keyframes;
    std::vector<Keyframe> mapped;  // Track::mapped after optimisation
    // Up to which frames may be fused so that the surfaces of segments do not meet; 0: no limit.
    double max_depth_m = 0.0;
    RectifiedRig rig;  // with the refined T_imu_cam
    RefinedCalibration calibration;
    CovarianceTrack covariances;  // of `trajectory`; empty: unknown
    PathPrior prior;              // of `keyframes`; empty unless asked for
    OptimiseStatistics statistics;
    std::vector<Finding> findings;
};

}  // namespace divemesh::types
