#include "worker/board_calibration/view_coverage.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace divemesh::board_calibration {
namespace {

int cell_of(double at, int size, int num) {
    return std::clamp(static_cast<int>(std::floor((at + 0.5) / size * num)), 0, num - 1);
}

void count(const boards::BoardCorners& corners, const LensKind& kind, ImageCoverage& coverage) {
    for (const boards::BoardCorner& corner : corners) {
        const CoverageCell cell = coverage_cell(corner.pixel, {kind.width_px, kind.height_px});
        ++coverage.num_corners[static_cast<std::size_t>(cell.row)]
                              [static_cast<std::size_t>(cell.column)];
    }
}

void widen(double value, bool is_first, Spread& spread) {
    spread.min = is_first ? value : std::min(spread.min, value);
    spread.max = is_first ? value : std::max(spread.max, value);
}

}  // namespace

CoverageCell coverage_cell(const Eigen::Vector2d& pixel, cv::Size size) {
    return {cell_of(pixel.x(), size.width, kCoverageColumns),
            cell_of(pixel.y(), size.height, kCoverageRows)};
}

double ImageCoverage::share() const {
    int num_seen = 0;
    for (const auto& row : num_corners)
        for (const int num : row) num_seen += num > 0 ? 1 : 0;
    return static_cast<double>(num_seen) / (kCoverageColumns * kCoverageRows);
}

std::vector<std::string> ImageCoverage::empty_sixths() const {
    std::array<std::array<int, 3>, 2> sums = {};
    for (std::size_t row = 0; row < num_corners.size(); ++row)
        for (std::size_t column = 0; column < num_corners[row].size(); ++column)
            sums[2 * row / kCoverageRows][3 * column / kCoverageColumns] +=
                num_corners[row][column];
    constexpr std::array kRows = {"upper", "lower"};
    constexpr std::array kColumns = {"left", "middle", "right"};
    std::vector<std::string> empty;
    for (std::size_t row = 0; row < 2; ++row)
        for (std::size_t column = 0; column < 3; ++column)
            if (sums[row][column] == 0)
                empty.push_back(std::string(kRows[row]) + " " + kColumns[column]);
    return empty;
}

ViewCoverage coverage_of(const boards::Board& board,
                         const RigParameters& rig,
                         const std::vector<PosedView>& views) {
    ViewCoverage coverage;
    bool is_first = true;
    for (const PosedView& posed : views) {
        count(posed.view.left, rig.kind0, coverage.left);
        count(posed.view.right, rig.kind1, coverage.right);
        const Eigen::Isometry3d T_cam0_board = isometry_of(posed.T_cam0_board);
        const double cosine = std::min(1.0, std::abs(T_cam0_board.linear()(2, 2)));
        widen((T_cam0_board * board.center_m()).norm(), is_first, coverage.distance_m);
        widen(std::acos(cosine) * 180.0 / std::numbers::pi, is_first, coverage.tilt_deg);
        is_first = false;
    }
    return coverage;
}

}  // namespace divemesh::board_calibration
