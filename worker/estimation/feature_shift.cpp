#include "worker/estimation/feature_shift.hpp"

#include <algorithm>
#include <vector>

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
    if (shifts_px.empty()) return {};
    const auto middle = shifts_px.begin() + std::ssize(shifts_px) / 2;
    std::nth_element(shifts_px.begin(), middle, shifts_px.end());
    return {shifts_px.size(), *middle};
}

}  // namespace divemesh::worker
