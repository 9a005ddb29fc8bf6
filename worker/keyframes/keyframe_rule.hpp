#pragma once

#include <cstddef>
#include <cstdint>

#include "worker/features/feature_shift.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::keyframes {

// When a frame is to be kept: the view has moved on, or too little is left of what the last
// keyframe saw.
class KeyframeRule {
public:
    explicit KeyframeRule(const types::RectifiedRig& rig) : width_px_(rig.width_px) {}

    bool due(const types::Features& features, std::int64_t timestamp_ns);
    void taken(const types::Features& features, std::int64_t timestamp_ns);

private:
    int width_px_;
    bool any_ = false;
    std::int64_t timestamp_ns_ = 0;
    std::size_t num_reference_ = 0;  // that outlived the first frame; 0: not counted yet
    features::FeatureShift shift_;
};

}  // namespace divemesh::keyframes
