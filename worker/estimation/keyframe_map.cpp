#include "worker/estimation/keyframe_map.hpp"

namespace divemesh::worker {
namespace {

constexpr std::size_t kFewestForInertia = 4;  // keyframes that tell velocity and vertical
constexpr double kWindowBiasSigma = 3e-4;     // rad/s, of the bias that a window has estimated

}  // namespace

void KeyframeMap::add(const RectifiedFrame& frame,
                      const Features& features,
                      Motion& motion,
                      InertialPrior& inertial) {
    rule_.taken(features, frame.timestamp_ns);
    const Keyframe keyframe{frame.index, frame.timestamp_ns, motion.T_world_cam()};
    const std::int64_t before_ns = empty() ? frame.timestamp_ns : last_ns_;
    last_ns_ = frame.timestamp_ns;
    const bool first = window_.empty();
    window_.add_keyframe(keyframe, features, inertial.readings(before_ns, frame.timestamp_ns));
    if (first) return;
    window_.adjust();
    motion.correct(window_.T_world_cam());
    if (inertial.has_accelerometer() && window_.keyframes().size() >= kFewestForInertia)
        motion.correct(window_.state().velocity_world, window_.reference().down_world);
    inertial.set_bias(window_.state().bias, kWindowBiasSigma);
}

void KeyframeMap::move_to(Track& track) const {
    track.keyframes = window_.keyframes();
    track.landmarks = window_.landmarks();
}

}  // namespace divemesh::worker
