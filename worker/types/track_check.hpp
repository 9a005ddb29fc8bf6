#pragma once

namespace divemesh::types {

// How well a track agrees with the measurements; a step is checked by comparing the values before
// and after it.
struct TrackAgreement {
    bool finite = true;
    // Over the observations made during tracking, each error limited to 10 px.
    double reprojection_rms_px = 0.0;
    // The deviation of the motions between neighbouring keyframes from the odometry.
    double odometry_rms_sigmas = 0.0;
};

// How a step changed a track.
struct TrackCheck {
    TrackAgreement before;
    TrackAgreement after;
    // RMS distance that keyframes moved relative to the first one, in standard deviations by the
    // track's drift and, where it is known, the result's covariance.
    double moved_rms_sigmas = 0.0;
};

}  // namespace divemesh::types
