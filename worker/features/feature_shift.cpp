#include "worker/features/feature_shift.hpp"

#include <vector>

#include "worker/stats/median.hpp"

namespace divemesh::features {

void FeatureShift::start(const types::Features& features) {
    pixels_.clear();
    for (const types::Feature& feature : features) pixels_.emplace(feature.id, feature.pixel);
}

FeatureShift::Shift FeatureShift::since(const types::Features& features) const {
    std::vector<double> shifts_px;
    for (const types::Feature& feature : features) {
        const auto before = pixels_.find(feature.id);
        if (before != pixels_.end()) shifts_px.push_back((feature.pixel - before->second).norm());
    }
    const std::size_t num_shared = shifts_px.size();
    return {num_shared, stats::upper_median(std::move(shifts_px))};
}

}  // namespace divemesh::features
