#include "worker/pipeline/observe_frame.hpp"

#include <utility>

#include "worker/features/match_sparse_stereo.hpp"
#include "worker/odometry/frame_features.hpp"
#include "worker/odometry/register_with_rotation.hpp"

namespace divemesh::pipeline {
namespace {

using odometry::kInlierTolerance_px;

odometry::Registration register_pairs(const TrackingState& state,
                                      const types::RectifiedFrame& frame,
                                      const odometry::PointPairs& pairs,
                                      const PredictedMotion& prediction) {
    const auto motion_of = [&](const odometry::PointPairs& voting) {
        return odometry::register_with_rotation(state.rig,
                                                voting,
                                                prediction.rotation,
                                                prediction.T_current_previous,
                                                kInlierTolerance_px,
                                                odometry::seed_of(state.options.seed, frame));
    };
    const auto is_contradicted = [&](const odometry::Registration& vision) {
        return vision.found && state.scene.contradicts(state.features, pairs, vision);
    };
    odometry::Registration vision = motion_of(pairs);
    if (is_contradicted(vision)) {
        const odometry::Registration by_known = motion_of(state.scene.known(pairs));
        vision = odometry::register_near(
            state.rig,
            pairs,
            prediction.rotation,
            by_known.found ? by_known.T_current_previous : prediction.T_current_previous,
            kInlierTolerance_px);
        if (is_contradicted(vision)) vision.found = false;
    }
    // Once the pose is unknown, so is what the frame would have shown.
    if (vision.found && !state.motion.is_lost(frame.timestamp_ns) &&
        state.scene.is_hidden_behind(vision, state.motion.T_world_cam()))
        vision.found = false;
    return vision;
}

}  // namespace

Observed observe_frame(TrackingState& state,
                       const types::RectifiedFrame& frame,
                       types::Features tracks,
                       const PredictedMotion& prediction) {
    Observed seen;
    seen.tracks = std::move(tracks);
    features::match_sparse_stereo(frame, {}, state.options.num_disparities_px, seen.tracks);  // 1
    state.dynamic_features.take_dynamic(seen.tracks);
    seen.measured =
        odometry::with_depth_at_both_times(state.rig, state.features, seen.tracks);  // 3
    seen.pairs = seen.measured;
    state.map.use_landmarks(state.motion.T_world_cam(), seen.pairs);
    seen.vision = register_pairs(state, frame, seen.pairs, prediction);  // 4
    return seen;
}

}  // namespace divemesh::pipeline
