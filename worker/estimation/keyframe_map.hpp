#pragma once

#include <limits>
#include <vector>

#include "schemas/reconstruction_options.hpp"
#include "worker/estimation/inertial_prior.hpp"
#include "worker/estimation/keyframe_rule.hpp"
#include "worker/estimation/motion.hpp"
#include "worker/estimation/window.hpp"
#include "worker/track.hpp"

namespace divemesh::worker {

// The frames that are kept, and what they saw. With the pairwise estimator (the paper) they are
// frames like any other; with the window estimator each of them adjusts the last ones together.
class KeyframeMap {
public:
    KeyframeMap(const RectifiedRig& rig,
                const ReconstructionOptions& options,
                const InertialPrior& inertial);

    // Landmarks take the place of the points measured at t-1 (window estimator).
    void use_landmarks(const Eigen::Isometry3d& T_world_previous, PointPairs& pairs) const;

    bool empty() const { return last_ns_ == kNever; }
    bool due(const Features& features, std::int64_t timestamp_ns);

    // With the window estimator gives back a better pose to `motion` and a better bias to
    // `inertial`.
    void add(const RectifiedFrame& frame,
             const Features& features,
             Motion& motion,
             InertialPrior& inertial);

    // Keyframes and landmarks as last estimated.
    void move_to(Track& track);

private:
    static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min();

    RectifiedRig rig_;
    bool pairwise_;
    KeyframeRule rule_;
    Window window_;
    std::vector<Keyframe> keyframes_;  // of the pairwise estimator
    std::int64_t last_ns_ = kNever;
};

}  // namespace divemesh::worker
