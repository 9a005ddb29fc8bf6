#include "worker/pipeline/keyframe_map.hpp"

namespace divemesh::pipeline {
namespace {

// Keyframes that determine velocity and vertical.
constexpr std::size_t kMinKeyframesForInertia = 4;
constexpr double kWindowBiasSigma = 3e-4;  // rad/s, of a bias estimated by the sliding window

}  // namespace

void KeyframeMap::add(const types::RectifiedFrame& frame,
                      const types::Features& features,
                      odometry::MotionModel& motion,
                      imu::InertialPrior& inertial) {
    rule_.taken(features, frame.timestamp_ns);
    const types::Keyframe keyframe{frame.index, frame.timestamp_ns, motion.T_world_cam()};
    const std::int64_t before_ns = empty() ? frame.timestamp_ns : last_ns_;
    last_ns_ = frame.timestamp_ns;
    const bool first = sliding_window_.empty();
    sliding_window_.add_keyframe(
        keyframe, features, inertial.readings(before_ns, frame.timestamp_ns));
    if (first) return;
    const types::SolverOutcome outcome = sliding_window_.adjust();
    solver_.add(outcome);
    if (outcome.failed()) return;  // the motion model goes on
    motion.correct(sliding_window_.T_world_cam());
    if (inertial.has_accelerometer() &&
        sliding_window_.keyframes().size() >= kMinKeyframesForInertia)
        motion.correct(sliding_window_.state().velocity_world,
                       sliding_window_.reference().gravity_direction_world);
    inertial.set_bias(sliding_window_.state().bias, kWindowBiasSigma);
}

void KeyframeMap::move_to(types::Track& track) const {
    track.keyframes = sliding_window_.keyframes();
    track.landmarks = sliding_window_.landmarks();
    track.statistics.window_solver = solver_;
}

}  // namespace divemesh::pipeline
