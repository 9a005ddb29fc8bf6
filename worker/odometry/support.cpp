#include "worker/odometry/support.hpp"

#include <set>
#include <utility>
#include <vector>

#include "worker/stats/median.hpp"

namespace divemesh::odometry {
namespace {

constexpr std::size_t kMinSupport = 20;
constexpr std::size_t kMinSupportNearPrediction = 10;
constexpr double kMinShareOfPrevious = 0.4;
constexpr double kMinShareOfPairs = 0.7;
constexpr double kNearPrediction_px = 4.0;
constexpr int kCellColumns = 8;
constexpr int kCellRows = 6;
constexpr std::size_t kMinCells = 6;  // cells of the image with an inlier

// Returns the median distance of the pairs from where the motion predicts them, in the left image.
double median_error_px(const types::RectifiedRig& rig,
                       const PointPairs& pairs,
                       const Eigen::Isometry3d& T_current_previous) {
    std::vector<double> errors_px;
    for (const PointPair& pair : pairs)
        errors_px.push_back(
            (rig.pixel(T_current_previous * pair.p_previous) - pair.current_px.head<2>()).norm());
    return stats::upper_median(std::move(errors_px));
}

}  // namespace

std::size_t num_cells(const types::RectifiedRig& rig, const PointPairs& pairs) {
    std::set<int> cells;
    for (const PointPair& pair : pairs)
        cells.insert(static_cast<int>(pair.current_px.y() * kCellRows / rig.height_px) *
                         kCellColumns +
                     static_cast<int>(pair.current_px.x() * kCellColumns / rig.width_px));
    return cells.size();
}

bool well_supported(const types::RectifiedRig& rig,
                    const Registration& motion,
                    std::size_t num_previous,
                    const Eigen::Isometry3d& expected) {
    const auto num = static_cast<double>(motion.inliers.size());
    if (!motion.found || num < kMinShareOfPairs * static_cast<double>(motion.num_pairs) ||
        num_cells(rig, motion.inliers) < kMinCells)
        return false;
    if (median_error_px(rig, motion.inliers, expected) < kNearPrediction_px)
        return motion.inliers.size() >= kMinSupportNearPrediction;
    return motion.inliers.size() >= kMinSupport &&
           num >= kMinShareOfPrevious * static_cast<double>(num_previous);
}

}  // namespace divemesh::odometry
