#include "worker/compare/outlined_cells.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>

#include "worker/reef/area_plane.hpp"

namespace divemesh::compare {
namespace {

// Returns the part of the map around an outline, with a margin of one cell.
cv::Rect window_about(const reef::Polygon& corners, const RasterGrid& grid) {
    Eigen::AlignedBox2d box;
    for (const Eigen::Vector2d& p : corners) box.extend(p);
    const auto within = [](double place, int max) {
        return static_cast<int>(std::clamp(place, 0.0, static_cast<double>(max)));
    };
    const cv::Point low(within(box.min().x(), grid.columns), within(box.min().y(), grid.rows));
    const cv::Point high(within(box.max().x() + 1.0, grid.columns),
                         within(box.max().y() + 1.0, grid.rows));
    return {low, high};
}

// Returns where the outline crosses a horizontal line, from left to right.
std::vector<double> crossings(const reef::Polygon& corners, double y) {
    std::vector<double> places;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Eigen::Vector2d& a = corners[i];
        const Eigen::Vector2d& b = corners[(i + 1) % corners.size()];
        if ((a.y() <= y) == (b.y() <= y)) continue;
        places.push_back(a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x()));
    }
    std::sort(places.begin(), places.end());
    return places;
}

}  // namespace

reef::Polygon outline_from_above(const reef::Area& area) {
    reef::Area level = area;
    level.normal = Eigen::Vector3d::UnitZ();
    reef::plane_of(level);
    reef::Polygon outline;
    for (const Eigen::Vector3d& point : area.points) outline.emplace_back(point.head<2>());
    return outline;
}

reef::Polygon in_cells(const reef::Polygon& outline, const RasterGrid& grid) {
    reef::Polygon corners;
    for (const Eigen::Vector2d& p : outline)
        corners.emplace_back((p.x() - grid.corner_m.x()) / grid.cell_m,
                             (grid.corner_m.y() - p.y()) / grid.cell_m);
    return corners;
}

int OutlinedCells::num_on(const cv::Mat& map) const {
    return window.empty() ? 0 : cv::countNonZero(cells & map(window));
}

void OutlinedCells::add_to(cv::Mat& map) const {
    if (!window.empty()) map(window) |= cells;
}

double share_on(const OutlinedCells& within, double area_m2, const cv::Mat& map, double cell_m) {
    if (within.window.empty()) return 0.0;
    const double num =
        std::max(static_cast<double>(cv::countNonZero(within.cells)), area_m2 / (cell_m * cell_m));
    return within.num_on(map) / num;
}

OutlinedCells cells_within(const reef::Polygon& outline, const RasterGrid& grid) {
    const reef::Polygon corners = in_cells(outline, grid);
    OutlinedCells within;
    within.window = window_about(corners, grid);
    within.cells = cv::Mat::zeros(within.window.size(), CV_8U);
    for (int row = 0; row < within.cells.rows; ++row) {
        const std::vector<double> places = crossings(corners, within.window.y + row + 0.5);
        for (std::size_t i = 0; i + 1 < places.size(); i += 2) {
            const auto column = [&](double place) {
                return static_cast<int>(std::clamp(std::ceil(place - 0.5) - within.window.x,
                                                   0.0,
                                                   static_cast<double>(within.cells.cols)));
            };
            within.cells.row(row)
                .colRange(column(places[i]), column(places[i + 1]))
                .setTo(cv::Scalar::all(255));
        }
    }
    return within;
}

}  // namespace divemesh::compare
