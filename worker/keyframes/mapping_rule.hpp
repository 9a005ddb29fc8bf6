#pragma once

#include "worker/features/feature_shift.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::keyframes {

// Which frames beside the keyframes are matched densely and fused. More views of a surface average
// the noise of its depth and confirm it, but neighbouring frames have much of their error in
// common, so the picture has to move on between them.
class MappingRule {
public:
    // `step`: how far, as a share of the picture's width; 0: keyframes alone.
    MappingRule(const types::RectifiedRig& rig, double step) : step_px_(step * rig.width_px) {}

    bool due(const types::Features& features) const {
        return step_px_ > 0.0 && shift_.since(features).median_px >= step_px_;
    }
    void taken(const types::Features& features) { shift_.start(features); }

private:
    double step_px_;
    features::FeatureShift shift_;
};

}  // namespace divemesh::keyframes
