#include "worker/odometry/support.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "worker/odometry/num_cells.hpp"
#include "worker/stats/median.hpp"
#include "worker/stats/ratio.hpp"

namespace divemesh::odometry {
namespace {

constexpr std::size_t kMinSupport = 20;
constexpr std::size_t kMinSupportNearPrediction = 10;
constexpr double kMinShareOfPrevious = 0.4;
constexpr double kMinShareOfPairs = 0.7;
constexpr std::size_t kMinUnexpected = 12;
constexpr double kMinUnexpectedShare = 0.5;  // of the pairs
// Share of the previous features. Features are looked for where the motion is expected, so the few
// that are found there by mistake agree with it.
constexpr double kMinShareFound = 0.05;
// Where the texture repeats, a tenth of them finds a neighbour that agrees with a wrong motion.
constexpr double kMinUnexpectedShareFound = 0.15;
constexpr double kNearPrediction_px = 4.0;  // in images of kNearWidth_px or less
constexpr double kNearWidth_px = 640.0;     // the same motion moves more pixels of wider ones
constexpr std::size_t kMinCells = 6;        // cells of the image with an inlier

// Returns the share of a part; 1 if the whole is 0, because then no item is missing.
double share_or_all(std::size_t part, std::size_t whole) {
    return whole > 0 ? stats::ratio(part, whole) : 1.0;
}

// Returns the median distance of the pairs from where the motion predicts them, in the left image.
double median_error_px(const types::RectifiedRig& rig,
                       const PointPairs& pairs,
                       const Eigen::Isometry3d& T_current_previous) {
    std::vector<double> errors_px;
    errors_px.reserve(pairs.size());
    for (const PointPair& pair : pairs)
        errors_px.push_back(
            (rig.pixel(T_current_previous * pair.p_previous) - pair.current_px.head<2>()).norm());
    return stats::upper_median(std::move(errors_px));
}

}  // namespace

std::size_t num_cells(const types::RectifiedRig& rig, const PointPairs& pairs) {
    return num_cells(rig, pairs, [](const PointPair& pair) {
        return Eigen::Vector2d(pair.current_px.head<2>());
    });
}

bool is_near_prediction(const types::RectifiedRig& rig,
                        const PointPairs& pairs,
                        const Eigen::Isometry3d& expected) {
    const double times_wider = std::max(1.0, rig.width_px / kNearWidth_px);
    return median_error_px(rig, pairs, expected) < kNearPrediction_px * times_wider;
}

bool well_supported(const types::RectifiedRig& rig,
                    const Registration& motion,
                    std::size_t num_previous,
                    const std::optional<Eigen::Isometry3d>& expected) {
    const std::size_t num = motion.inliers.size();
    if (!motion.found || num_cells(rig, motion.inliers) < kMinCells) return false;
    const bool most_agree = share_or_all(num, motion.num_pairs) >= kMinShareOfPairs;
    if (!most_agree) return false;
    if (expected && is_near_prediction(rig, motion.inliers, *expected))
        return num >= kMinSupportNearPrediction &&
               share_or_all(num, num_previous) >= kMinShareFound;
    return num >= kMinSupport && share_or_all(num, num_previous) >= kMinShareOfPrevious;
}

bool explained_by_chance(const types::RectifiedRig& rig,
                         const Registration& motion,
                         std::size_t num_previous,
                         const std::optional<Eigen::Isometry3d>& expected) {
    const std::size_t num = motion.inliers.size();
    if (share_or_all(num, num_previous) < kMinShareFound) return true;
    if (expected && is_near_prediction(rig, motion.inliers, *expected)) return false;
    return num < kMinUnexpected || share_or_all(num, motion.num_pairs) < kMinUnexpectedShare ||
           share_or_all(num, num_previous) < kMinUnexpectedShareFound;
}

}  // namespace divemesh::odometry
