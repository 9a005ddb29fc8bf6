#include "worker/odometry/support.hpp"

#include <set>

namespace divemesh::odometry {
namespace {

constexpr std::size_t kMinSupport = 20;
constexpr double kMinShareOfPrevious = 0.15;
constexpr double kMinShareOfPairs = 0.5;
constexpr int kCellColumns = 8;
constexpr int kCellRows = 6;
constexpr std::size_t kMinCells = 6;  // cells of the image with an inlier

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
                    std::size_t num_previous) {
    const std::size_t num = motion.inliers.size();
    return motion.found && num >= kMinSupport &&
           static_cast<double>(num) >= kMinShareOfPrevious * static_cast<double>(num_previous) &&
           static_cast<double>(num) >= kMinShareOfPairs * static_cast<double>(motion.num_pairs) &&
           num_cells(rig, motion.inliers) >= kMinCells;
}

}  // namespace divemesh::odometry
