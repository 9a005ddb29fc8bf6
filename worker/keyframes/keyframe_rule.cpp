#include "worker/keyframes/keyframe_rule.hpp"

namespace divemesh::keyframes {
namespace {

constexpr double kMinShare = 0.65;  // of the last keyframe's features still tracked
constexpr std::size_t kMinTracked = 50;
constexpr std::size_t kMinTies = 10;  // while the camera stands still
constexpr double kMaxShift = 0.06;    // median, of the image width
constexpr double kMinShift = 0.002;   // below it the camera stands still
constexpr std::int64_t kMaxKeyframeInterval_ns = 1'000'000'000;

}  // namespace

bool KeyframeRule::due(const types::Features& features, std::int64_t timestamp_ns) {
    if (!any_) return true;
    const auto [num_shared, median_px] = shift_.since(features);
    // New features that are lost at once do not show how far the image has moved.
    if (num_reference_ == 0) num_reference_ = num_shared;
    if (num_shared < kMinTracked ||
        static_cast<double>(num_shared) < kMinShare * static_cast<double>(num_reference_))
        return true;
    const double shift = median_px / width_px_;
    return shift > kMaxShift ||
           (shift > kMinShift && timestamp_ns - timestamp_ns_ > kMaxKeyframeInterval_ns);
}

bool KeyframeRule::due_at_rest(const types::Features& features) const {
    return shift_.since(features).num_shared < kMinTies;
}

void KeyframeRule::taken(const types::Features& features, std::int64_t timestamp_ns) {
    any_ = true;
    timestamp_ns_ = timestamp_ns;
    num_reference_ = 0;
    shift_.start(features);
}

}  // namespace divemesh::keyframes
