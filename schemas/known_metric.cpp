#include "schemas/known_metric.hpp"

#include <algorithm>
#include <initializer_list>

namespace divemesh {
namespace {

bool ends_with_any(const std::string& name, std::initializer_list<const char*> endings) {
    return std::any_of(
        endings.begin(), endings.end(), [&](const char* ending) { return name.ends_with(ending); });
}

bool contains_any(const std::string& name, std::initializer_list<const char*> words) {
    return std::any_of(words.begin(), words.end(), [&](const char* word) {
        return name.find(word) != std::string::npos;
    });
}

}  // namespace

std::string_view to_string(BetterValue better) {
    switch (better) {
        case BetterValue::Lower: return "lower";
        case BetterValue::Higher: return "higher";
        case BetterValue::None: return "none";
    }
    return "none";
}

BetterValue better_value(const std::string& name) {
    const std::string last = name.substr(name.rfind('.') + 1);
    if (name.starts_with("speed.") || name.starts_with("calibration.")) return BetterValue::None;
    if (ends_with_any(last,
                      {"coverage",
                       "precision",
                       "recall",
                       "f1",
                       "covered_share",
                       "covered_share_of_matched",
                       "share_20mm",
                       "share_in_95",
                       "share_3_views_or_more",
                       "inlier_share",
                       "num_frames_tracked",
                       "num_measured",
                       "num_accepted",
                       "mean_tracked_features"}))
        return BetterValue::Higher;
    if (contains_any(name, {"accuracy.", "completeness."}) && name.starts_with("surface."))
        return last == "num_samples" ? BetterValue::None : BetterValue::Lower;
    return contains_any(last,
                        {"error",
                         "false_share",
                         "ate_",
                         "drift",
                         "rms",
                         "sigma",
                         "bound",
                         "expected_m",
                         "disagreement",
                         "num_degenerate_frames",
                         "num_skipped_frames",
                         "num_poses_outside"})
               ? BetterValue::Lower
               : BetterValue::None;
}

}  // namespace divemesh
