#pragma once

#include "worker/features/feature_shift.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::keyframes {

// The rule for which frames besides the keyframes are matched densely and fused. More observations
// of a surface average the noise of its depth and confirm it. Neighbouring frames share much of
// their error, so the image has to move between them.
class MappingRule {
public:
    // `step` is the min movement as a fraction of the image width; 0: keyframes only.
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
