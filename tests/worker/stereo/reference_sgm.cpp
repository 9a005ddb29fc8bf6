#include "tests/worker/stereo/reference_sgm.hpp"

#include <algorithm>
#include <bitset>
#include <cstdint>
#include <cstdlib>
#include <vector>

namespace divemesh::stereo {
namespace {

constexpr int kSmallStep = 8;  // P1
constexpr int kMaxCost = 255;
constexpr int kOutside = 210;  // cost of a path outside the range
constexpr int kBits = 32;

// One cost per pixel and disparity.
struct CostVolume {
    CostVolume(cv::Size size_, int range_)
        : size(size_), range(range_), values(static_cast<std::size_t>(size.area()) * range) {}

    int& at(int x, int y, int d) {
        return values[(static_cast<std::size_t>(y) * size.width + x) * range + d];
    }
    int at(int x, int y, int d) const {
        return values[(static_cast<std::size_t>(y) * size.width + x) * range + d];
    }

    cv::Size size;
    int range;
    std::vector<int> values;
};

int mirrored(int i, int num) { return i < 0 ? -i : i >= num ? 2 * (num - 1) - i : i; }

// Returns the census bits: each is set if a neighbour is at least as bright as the centre plus or
// minus the tolerance. The neighbours are the chequerboard of the 9 x 7 window, plus and minus in
// turns, its upper right corner (plus) and its lower left one (minus). The image is mirrored beyond
// its border.
std::bitset<kBits> signature(const cv::Mat& image, int x, int y, int tolerance) {
    std::bitset<kBits> bits;
    std::size_t bit = 0;
    const auto compare = [&](int dx, int dy) {
        const int center = image.at<std::uint8_t>(y, x);
        const int limit =
            bit % 2 == 0 ? std::min(255, center + tolerance) : std::max(0, center - tolerance);
        bits[bit++] = image.at<std::uint8_t>(mirrored(y + dy, image.rows),
                                             mirrored(x + dx, image.cols)) >= limit;
    };
    for (int dy = -3; dy <= 3; ++dy)
        for (int dx = -4; dx <= 4; ++dx)
            if ((dx + dy) % 2 == 0 && (dx != 0 || dy != 0)) compare(dx, dy);
    compare(4, -3);
    compare(-4, 3);
    return bits;
}

CostVolume matching_costs(const cv::Mat& left, const cv::Mat& right, int range, int tolerance) {
    CostVolume costs(left.size(), range);
    for (int y = 0; y < left.rows; ++y)
        for (int x = 0; x < left.cols; ++x) {
            const auto bits = signature(left, x, y, tolerance);
            for (int d = 0; d < range; ++d)
                costs.at(x, y, d) =
                    d > x
                        ? kBits
                        : static_cast<int>((bits ^ signature(right, x - d, y, tolerance)).count());
        }
    return costs;
}

int large_step(const cv::Mat& image, cv::Point a, cv::Point b) {  // P2
    const int step = std::abs(image.at<std::uint8_t>(a) - image.at<std::uint8_t>(b));
    return std::max(25, 80 * 12 / (12 + step));
}

// Adds the costs along the path that comes to a pixel from `from`: Hirschmueller 2008, eq. 14.
void add_path(const cv::Mat& image, const CostVolume& costs, cv::Point from, CostVolume& sums) {
    const cv::Rect inside({0, 0}, image.size());
    CostVolume path(costs.size, costs.range);
    for (int i = 0; i < image.rows; ++i)
        for (int j = 0; j < image.cols; ++j) {
            const cv::Point here(from.x > 0 ? image.cols - 1 - j : j, i);
            const cv::Point before = here + from;
            const bool starts = !inside.contains(before);
            int min_cost = starts ? 0 : kMaxCost;
            for (int d = 0; !starts && d < costs.range; ++d)
                min_cost = std::min(min_cost, path.at(before.x, before.y, d));
            const auto cost_before = [&](int d) {
                return d < 0 || d >= costs.range ? kOutside : path.at(before.x, before.y, d);
            };
            for (int d = 0; d < costs.range; ++d) {
                int way = 0;
                if (!starts)
                    way = std::min({cost_before(d),
                                    cost_before(d - 1) + kSmallStep,
                                    cost_before(d + 1) + kSmallStep,
                                    min_cost + large_step(image, here, before)});
                path.at(here.x, here.y, d) = costs.at(here.x, here.y, d) + way - min_cost;
                int& sum = sums.at(here.x, here.y, d);
                sum = std::min(kMaxCost, sum + path.at(here.x, here.y, d));
            }
        }
}

int winner(const CostVolume& sums, int x, int y) {
    int best = 0;
    for (int d = 1; d < sums.range; ++d)
        if (sums.at(x, y, d) < sums.at(x, y, best)) best = d;
    return best;
}

// Returns true if no disparity other than the winner and its neighbours costs within 5 % of the
// winner.
bool is_unique(const CostVolume& sums, int x, int y, int best) {
    const int min_cost = sums.at(x, y, best);
    if (best == 0 || best == sums.range - 1 || min_cost == kMaxCost) return false;
    const int limit = std::min(kMaxCost, min_cost * 100 / 95);
    for (int d = 0; d < sums.range; ++d)
        if (std::abs(d - best) > 1 && sums.at(x, y, d) <= limit) return false;
    return true;
}

// Returns the cheapest of the winners that match one pixel of the right image, the rightmost if
// equal.
int right_winner(const CostVolume& sums, const std::vector<int>& winners, int right_x, int y) {
    int best = -1;
    int min_cost = kMaxCost;
    for (int x = std::min(sums.size.width - 1, right_x + sums.range - 1); x >= right_x; --x) {
        if (winners[x] != x - right_x || sums.at(x, y, winners[x]) >= min_cost) continue;
        min_cost = sums.at(x, y, winners[x]);
        best = winners[x];
    }
    return best;
}

float between(int before, int at, int after, int d) {
    const int slope = std::max(before, after) - at;
    if (slope == 0) return static_cast<float>(d);
    return static_cast<float>(d) +
           0.5F * static_cast<float>(before - after) / static_cast<float>(slope);
}

}  // namespace

cv::Mat reference_sgm(const cv::Mat& left,
                      const cv::Mat& right,
                      int num_disparities,
                      int tolerance) {
    const CostVolume costs = matching_costs(left, right, num_disparities, tolerance);
    CostVolume sums(left.size(), num_disparities);
    for (const cv::Point from : {cv::Point(-1, 0), {1, 0}, {-1, -1}, {0, -1}, {1, -1}})
        add_path(left, costs, from, sums);
    cv::Mat disparity(left.size(), CV_32F, cv::Scalar(0.0));
    for (int y = 0; y < left.rows; ++y) {
        std::vector<int> winners;
        for (int x = 0; x < left.cols; ++x) winners.push_back(winner(sums, x, y));
        for (int x = 0; x < left.cols; ++x) {
            const int d = winners[x];
            if (d >= x) continue;
            const bool confirmed = is_unique(sums, x, y, d) &&
                                   std::abs(right_winner(sums, winners, x - d, y) - d) <= 1;
            disparity.at<float>(y, x) =
                confirmed ? between(sums.at(x, y, d - 1), sums.at(x, y, d), sums.at(x, y, d + 1), d)
                          : static_cast<float>(-d);
        }
    }
    return disparity;
}

}  // namespace divemesh::stereo
