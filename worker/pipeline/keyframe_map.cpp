#include "worker/pipeline/keyframe_map.hpp"

#include <algorithm>
#include <numbers>

namespace divemesh::pipeline {
namespace {

// Keyframes that determine velocity and vertical.
constexpr std::size_t kMinKeyframesForInertia = 4;
constexpr double kWindowBiasSigma = 3e-4;  // rad/s, of a bias estimated by the sliding window

// The first frame of a dive has no features yet, so that a rest begins with the next one.
constexpr std::int64_t kFirstFrames_ns = 250'000'000;

// Returns the latest rest that contains a time.
std::optional<types::Rest> rest_at(const std::vector<types::Rest>& rests, std::int64_t time_ns) {
    const auto rest = std::find_if(rests.rbegin(), rests.rend(), [&](const types::Rest& r) {
        return r.from_ns <= time_ns && time_ns <= r.to_ns;
    });
    return rest == rests.rend() ? std::nullopt : std::optional(*rest);
}

}  // namespace

bool KeyframeMap::began_at_rest(const std::vector<types::Rest>& rests) const {
    return sliding_window_.keyframes().size() == 1 && !rests.empty() &&
           rests.front().from_ns <= last_ns_ + kFirstFrames_ns;
}

std::optional<types::MotionSigma> KeyframeMap::since_last(const types::Rest& rest) const {
    const bool is_first = sliding_window_.keyframes().size() == 1;
    if (!is_corrected_ || last_ns_ < rest.from_ns - (is_first ? kFirstFrames_ns : 0))
        return std::nullopt;
    // Each of the two has the error of a pose against the rest's first one.
    return types::MotionSigma{std::numbers::sqrt2 * rest.sigma_m,
                              std::numbers::sqrt2 * rest.sigma_rad};
}

void KeyframeMap::add(const types::RectifiedFrame& frame,
                      const types::Features& features,
                      const std::vector<types::Rest>& rests,
                      odometry::MotionModel& motion,
                      imu::InertialPrior& inertial) {
    rule_.taken(features, frame.timestamp_ns);
    const types::Keyframe keyframe{frame.index, frame.timestamp_ns, motion.T_world_cam()};
    const std::int64_t before_ns = empty() ? frame.timestamp_ns : last_ns_;
    const bool first = sliding_window_.empty();
    const auto rest = rest_at(rests, frame.timestamp_ns);
    if (began_at_rest(rests)) sliding_window_.set_at_rest();
    sliding_window_.add_keyframe(keyframe,
                                 features,
                                 inertial.readings(before_ns, frame.timestamp_ns),
                                 rest && !first ? since_last(*rest) : std::nullopt);
    if (rest && frame.timestamp_ns >= rest->from_ns + kSettled_ns) sliding_window_.set_at_rest();
    last_ns_ = frame.timestamp_ns;
    if (first) return;
    const types::SolverOutcome outcome = sliding_window_.adjust();
    solver_.add(outcome);
    is_corrected_ = !outcome.failed();
    if (!is_corrected_) return;  // the motion model goes on
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
