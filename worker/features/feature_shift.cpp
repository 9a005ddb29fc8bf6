#include "worker/features/feature_shift.hpp"

#include <vector>

#include "worker/stats/median.hpp"

namespace divemesh::worker {

void FeatureShift::start(const Features& features) {
    pixels_.clear();
    for (const Feature& feature : features) pixels_.emplace(feature.id, feature.pixel);
}

FeatureShift::Shift FeatureShift::since(const Features& features) const {
    std::vector<double> shifts_px;
    for (const Feature& feature : features) {
        const auto before = pixels_.find(feature.id);
        if (before != pixels_.end()) shifts_px.push_back((feature.pixel - before->second).norm());
    }
    const std::size_t num_shared = shifts_px.size();
    return {num_shared, upper_median(std::move(shifts_px))};
}

}  // namespace divemesh::worker
