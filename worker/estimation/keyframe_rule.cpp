#include "worker/estimation/keyframe_rule.hpp"

#include <algorithm>
#include <vector>

namespace divemesh::worker {
namespace {

constexpr double kLeastShare = 0.65;  // of the last keyframe's features still in sight
constexpr std::size_t kFewest = 50;
constexpr double kMostShift = 0.06;    // median, of the picture's width
constexpr double kLeastShift = 0.002;  // below it the camera stands still
constexpr std::int64_t kLongest_ns = 1'000'000'000;

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

}  // namespace

bool KeyframeRule::due(const Features& features, std::int64_t timestamp_ns) {
    if (!any_) return true;
    std::vector<double> shifts;
    for (const Feature& feature : features) {
        const auto before = pixels_.find(feature.id);
        if (before != pixels_.end()) shifts.push_back((feature.pixel - before->second).norm());
    }
    // Fresh features that do not live are no measure of how far the view has moved.
    if (num_reference_ == 0) num_reference_ = shifts.size();
    if (shifts.size() < kFewest ||
        static_cast<double>(shifts.size()) < kLeastShare * static_cast<double>(num_reference_))
        return true;
    const double shift = median(shifts) / width_px_;
    return shift > kMostShift ||
           (shift > kLeastShift && timestamp_ns - timestamp_ns_ > kLongest_ns);
}

void KeyframeRule::taken(const Features& features, std::int64_t timestamp_ns) {
    any_ = true;
    timestamp_ns_ = timestamp_ns;
    num_reference_ = 0;
    pixels_.clear();
    for (const Feature& feature : features) pixels_.emplace(feature.id, feature.pixel);
}

}  // namespace divemesh::worker
