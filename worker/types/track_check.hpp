#pragma once

namespace divemesh::types {

// How a track agrees with what was measured, to compare it before and after a step by.
struct TrackAgreement {
    bool finite = true;
    double reprojection_rms_px = 0.0;  // of what the track saw itself, each at most 10 px
    double odometry_rms_sigmas = 0.0;  // of the steps between neighbouring keyframes
};

// What a step did to a track.
struct TrackCheck {
    TrackAgreement before;
    TrackAgreement after;
    // How far keyframes moved against the first one, RMS, by the drift of the track and the
    // covariance of the result; 0: no covariance is known.
    double moved_rms_sigmas = 0.0;
};

}  // namespace divemesh::types
