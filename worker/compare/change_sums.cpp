#include "worker/compare/change_sums.hpp"

#include <algorithm>
#include <cmath>

#include "worker/stats/distributions.hpp"

namespace divemesh::compare {

ChangeSums sum_over(const ChangeMap& map, const cv::Mat& cells) {
    ChangeSums sums;
    const double cell_m2 = map.grid.cell_m * map.grid.cell_m;
    double num = 0.0;
    for (int row = 0; row < cells.rows; ++row)
        for (int column = 0; column < cells.cols; ++column) {
            if (cells.at<std::uint8_t>(row, column) == 0) continue;
            const auto change = static_cast<double>(map.change_m.at<float>(row, column));
            sums.volume_m3 += cell_m2 * change;
            sums.sigma_m += static_cast<double>(map.sigma_m.at<float>(row, column));
            sums.by_motion += cell_m2 * map.change_by_motion(row, column);
            if (std::abs(change) > std::abs(sums.max_change_m)) sums.max_change_m = change;
            num += 1.0;
        }
    sums.area_m2 = num * cell_m2;
    sums.sigma_m /= std::max(1.0, num);
    return sums;
}

ChangeMap window_of(const ChangeMap& map, const cv::Rect& window) {
    ChangeMap part = map;
    part.grid.corner_m += map.grid.cell_m * Eigen::Vector2d(window.x, -window.y);
    part.grid.rows = window.height;
    part.grid.columns = window.width;
    part.state = map.state(window);
    part.change_m = map.change_m(window);
    part.sigma_m = map.sigma_m(window);
    part.registration_m = map.registration_m(window);
    part.later_surface = map.later_surface(window);
    return part;
}

double noise_m3(const ChangeSums& sums, const ChangeNoise& noise) {
    return sums.area_m2 * sums.sigma_m * noise.sigma_of_mean(sums.area_m2);
}

stats::Estimate interval(double value, double noise, double shared) {
    const double half = stats::kNormal975 * std::hypot(noise, shared);
    return {value, value - half, value + half};
}

}  // namespace divemesh::compare
