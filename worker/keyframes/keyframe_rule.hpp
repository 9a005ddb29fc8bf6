#pragma once

#include <cstddef>
#include <cstdint>

#include "worker/features/feature_shift.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::keyframes {

// The rule for when a frame becomes a keyframe: the image has moved far enough, or too few features
// of the last keyframe are left.
class KeyframeRule {
public:
    explicit KeyframeRule(const types::RectifiedRig& rig) : width_px_(rig.width_px) {}

    bool due(const types::Features& features, std::int64_t timestamp_ns);
    // Returns true if a camera that stands still needs a keyframe: hardly any features are left
    // that would tie a later one to the last.
    bool due_at_rest(const types::Features& features) const;
    void taken(const types::Features& features, std::int64_t timestamp_ns);

private:
    int width_px_;
    bool any_ = false;
    std::int64_t timestamp_ns_ = 0;
    // Features still tracked one frame after the keyframe; 0: not counted yet.
    std::size_t num_reference_ = 0;
    features::FeatureShift shift_;
};

}  // namespace divemesh::keyframes
