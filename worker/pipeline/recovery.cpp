#include "worker/pipeline/recovery.hpp"

#include <cstdint>
#include <utility>

#include "worker/odometry/frame_features.hpp"
#include "worker/odometry/support.hpp"

namespace divemesh::pipeline {
namespace {

constexpr int kNumPasses = 2;  // the first makes the motion more accurate for the second

}  // namespace

Observed Recovery::recover(const types::RectifiedFrame& frame,
                           const PredictedMotion& prediction,
                           Observed predicted) {
    const auto better = [](const Observed& a, const Observed& b) {
        return a.vision.found &&
               (!b.vision.found || a.vision.inliers.size() > b.vision.inliers.size());
    };
    const odometry::DynamicFeatures dynamic_features = state_.dynamic_features;
    if (auto followed = follow_wide(frame, prediction))
        if (better(*followed, predicted)) return std::move(*followed);
    state_.dynamic_features = dynamic_features;
    if (predicted.vision.found &&
        odometry::explained_by_chance(state_.rig,
                                      predicted.vision,
                                      odometry::num_with_depth(state_.features),
                                      prediction.expected()))
        predicted.vision.found = false;
    if (!predicted.vision.found)
        if (auto recognised = recognise(frame, prediction)) return std::move(*recognised);
    return predicted;
}

std::optional<Observed> Recovery::follow_wide(const types::RectifiedFrame& frame,
                                              const PredictedMotion& prediction) {
    const auto rough =
        state_.memory.register_to_previous(frame,
                                           {prediction.expected(), prediction.rotation},
                                           odometry::seed_of(state_.options.seed, frame));
    if (!rough) return std::nullopt;
    state_.dynamic_features.forget();
    Observed seen;
    seen.vision.T_current_previous = *rough;
    for (int pass = 0; pass < kNumPasses; ++pass) {
        const Eigen::Isometry3d motion = seen.vision.T_current_previous;
        seen = observe_frame(state_,
                             frame,
                             state_.tracker.track_again(state_.features, motion),
                             {prediction.rotation, motion});
        if (!seen.vision.found) return std::nullopt;
    }
    seen.predicted = false;
    return seen;
}

std::optional<Observed> Recovery::recognise(const types::RectifiedFrame& frame,
                                            const PredictedMotion& prediction) {
    const Eigen::Isometry3d T_world_previous = state_.motion.T_world_cam();
    auto known = state_.memory.recognise(frame,
                                         T_world_previous * prediction.T_current_previous.inverse(),
                                         odometry::seed_of(state_.options.seed, frame));
    if (!known) return std::nullopt;
    const types::Features previous = state_.features;
    const odometry::DynamicFeatures dynamic_features = state_.dynamic_features;
    // The previous pose becomes that from which the predicted motion leads here.
    state_.motion.correct(known->T_world_cam * prediction.T_current_previous);
    go_back_to(known->T_world_keyframe, known->in_keyframe);
    state_.dynamic_features.forget();
    Observed seen = observe_frame(state_, frame, std::move(known->features), prediction);
    seen.predicted = false;
    seen.recognised = true;
    if (seen.vision.found) return seen;
    state_.motion.correct(T_world_previous);
    state_.features = previous;
    state_.dynamic_features = dynamic_features;
    return std::nullopt;
}

// Sets the features to those of a keyframe, as the previous frame would have had them.
void Recovery::go_back_to(const Eigen::Isometry3d& T_world_keyframe,
                          const types::Features& in_keyframe) {
    const Eigen::Isometry3d T_previous_keyframe =
        state_.motion.T_world_cam().inverse() * T_world_keyframe;
    state_.features.clear();
    for (const types::Feature& feature : in_keyframe) {
        const Eigen::Vector3d p_previous =
            T_previous_keyframe * types::point_cam(state_.rig, feature);
        if (p_previous.z() < types::RectifiedRig::kMinDepth_m) continue;
        const Eigen::Vector3d pixel = types::project_px(state_.rig, p_previous);
        state_.features.push_back({feature.id, pixel.head<2>(), pixel.z()});
    }
}

}  // namespace divemesh::pipeline
