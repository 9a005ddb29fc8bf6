#include "worker/compare/change_noise.hpp"

#include <algorithm>
#include <cmath>

#include "worker/stats/distributions.hpp"
#include "worker/stats/quantile.hpp"

namespace divemesh::compare {
namespace {

constexpr std::size_t kMinBlocks = 12;
constexpr double kFull = 0.75;

std::vector<double> block_means(const ChangeMap& map, const cv::Mat& counts, int side) {
    std::vector<double> means;
    for (int top = 0; top + side <= counts.rows; top += side)
        for (int left = 0; left + side <= counts.cols; left += side) {
            double sum = 0.0;
            int num = 0;
            for (int row = top; row < top + side; ++row)
                for (int column = left; column < left + side; ++column) {
                    if (counts.at<std::uint8_t>(row, column) == 0) continue;
                    sum += static_cast<double>(map.change_m.at<float>(row, column) /
                                               map.sigma_m.at<float>(row, column));
                    ++num;
                }
            if (num >= kFull * side * side) means.push_back(sum / num);
        }
    return means;
}

}  // namespace

double ChangeNoise::sigma_of_mean(double area_m2) const {
    if (steps_.empty()) return 1.0;
    const double side_m = std::sqrt(area_m2);
    if (side_m <= steps_.front().side_m) return steps_.front().sigma;
    for (std::size_t i = 1; i < steps_.size(); ++i)
        if (side_m < steps_[i].side_m) {
            const double share = std::log(side_m / steps_[i - 1].side_m) /
                                 std::log(steps_[i].side_m / steps_[i - 1].side_m);
            return steps_[i - 1].sigma + share * (steps_[i].sigma - steps_[i - 1].sigma);
        }
    return steps_.back().sigma;
}

ChangeNoise measure_noise(const ChangeMap& map, const cv::Mat& counts) {
    std::vector<ChangeNoise::Step> steps;
    for (int side = 1; side <= std::min(counts.rows, counts.cols); side *= 2) {
        std::vector<double> sizes = block_means(map, counts, side);
        if (sizes.size() < kMinBlocks) break;
        for (double& size : sizes) size = std::abs(size);
        const double sigma = std::max(stats::lower_quantile(sizes, 0.683),
                                      stats::lower_quantile(sizes, 0.95) / stats::kNormal975);
        steps.push_back({side * map.grid.cell_m, sigma, sizes.size()});
    }
    return ChangeNoise(std::move(steps));
}

}  // namespace divemesh::compare
