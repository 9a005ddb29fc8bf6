#include "worker/stereo/fill_from_views.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "worker/base/hashed_random.hpp"
#include "worker/stereo/plane_correlation.hpp"
#include "worker/stereo/speckles.hpp"

namespace divemesh::stereo {
namespace {

// All sizes, disparities and gradients are those of the reduced image, unless they are named full.
constexpr int kWidth_px = 400;
constexpr int kMargin_px = PlaneCorrelation::kMargin_px;
constexpr int kNumRounds = 4;
constexpr float kMinCorrelation = 0.8F;
constexpr float kMaxSlope = 0.7F;  // of disparity per pixel
constexpr float kMaxSigma_full_px = 3.0F;
constexpr int kMinIsland_px = 40;

// Returns a number that depends on the pixel and the attempt alone, -1 to 1.
float random_at(int u, int v, int attempt) {
    return static_cast<float>(2.0 * base::to_unit(base::hash64(u, v, attempt)) - 1.0);
}

class HoleFiller {
public:
    HoleFiller(const types::RectifiedRig& rig,
               const cv::Mat& left,
               std::span<const NeighbourView> neighbours,
               int step_px)
        : correlation_(rig, left, neighbours, step_px),
          rig_(correlation_.rig()),
          step_px_(step_px) {}

    int fill(types::DepthMap& depth) {
        if (!read_planes(depth)) return 0;
        find_holes();
        for (int round = 0; round < kNumRounds; ++round) spread(round);
        accept();
        return write(depth);
    }

private:
    std::size_t index(int u, int v) const {
        return static_cast<std::size_t>(v) * rig_.width_px + static_cast<std::size_t>(u);
    }

    // Reads the planes of what was measured. Returns false if that is nothing.
    bool read_planes(const types::DepthMap& depth) {
        planes_.assign(index(0, rig_.height_px), {});
        known_.assign(planes_.size(), 0);
        std::vector<float> disparities;
        for (int v = 0; v < rig_.height_px; ++v)
            for (int u = 0; u < rig_.width_px; ++u) {
                const cv::Rect cell(u * step_px_, v * step_px_, step_px_, step_px_);
                const cv::Mat values = depth.disparity_px(cell);
                double low = 0.0, high = 0.0;
                cv::minMaxLoc(values, &low, &high);
                if (low <= 0.0 || high - low > 2.0 * step_px_) continue;
                const auto mean = static_cast<float>(cv::mean(values)[0] / step_px_);
                planes_[index(u, v)].disparity_px = mean;
                known_[index(u, v)] = 1;
                disparities.push_back(mean);
            }
        if (disparities.size() < 100) return false;
        set_slopes();
        const auto quantile = [&](double share) {
            const auto at =
                disparities.begin() +
                static_cast<std::ptrdiff_t>(share * static_cast<double>(disparities.size()));
            std::nth_element(disparities.begin(), at, disparities.end());
            return *at;
        };
        min_disparity_px_ = 0.7F * quantile(0.02);
        max_disparity_px_ = 1.4F * quantile(0.98);
        return true;
    }

    void set_slopes() {
        constexpr int kApart = 2;
        for (int v = 0; v < rig_.height_px; ++v)
            for (int u = 0; u < rig_.width_px; ++u) {
                if (known_[index(u, v)] == 0) continue;
                Plane& plane = planes_[index(u, v)];
                plane.slope_u = slope(u, v, kApart, 0);
                plane.slope_v = slope(u, v, 0, kApart);
            }
    }

    // Returns the slope of the disparity along an axis by what is known on either side.
    float slope(int u, int v, int du, int dv) const {
        const float center = planes_[index(u, v)].disparity_px;
        float sum = 0.0F;
        int count = 0;
        for (const int side : {-1, 1}) {
            const int x = u + side * du, y = v + side * dv;
            if (x < 0 || y < 0 || x >= rig_.width_px || y >= rig_.height_px) continue;
            if (known_[index(x, y)] == 0) continue;
            const float rise =
                (planes_[index(x, y)].disparity_px - center) / static_cast<float>(side * (du + dv));
            if (std::abs(rise) > kMaxSlope) continue;
            sum += rise;
            ++count;
        }
        return count > 0 ? sum / static_cast<float>(count) : 0.0F;
    }

    void find_holes() {
        costs_.assign(planes_.size(), PlaneCorrelation::kWorst);
        has_texture_.assign(planes_.size(), 0);
        for (int v = kMargin_px; v < rig_.height_px - kMargin_px; ++v)
            for (int u = kMargin_px; u < rig_.width_px - kMargin_px; ++u) {
                if (known_[index(u, v)] != 0) continue;
                if (correlation_.has_texture(correlation_.window_at(u, v)))
                    has_texture_[index(u, v)] = 1;
            }
    }

    bool is_plausible(const Plane& plane) const {
        return plane.disparity_px > min_disparity_px_ && plane.disparity_px < max_disparity_px_ &&
               std::abs(plane.slope_u) < kMaxSlope && std::abs(plane.slope_v) < kMaxSlope;
    }

    // One pass over the holes, forth in even rounds and back in odd ones.
    void spread(int round) {
        const int width = rig_.width_px, height = rig_.height_px;
        const int way = round % 2 == 0 ? -1 : 1;  // to the pixels that were visited before
        for (int j = kMargin_px; j < height - kMargin_px; ++j)
            for (int i = kMargin_px; i < width - kMargin_px; ++i) {
                const int u = round % 2 == 0 ? i : width - 1 - i;
                const int v = round % 2 == 0 ? j : height - 1 - j;
                if (has_texture_[index(u, v)] != 0) improve(u, v, way, round);
            }
    }

    void improve(int u, int v, int way, int round) {
        const PlaneCorrelation::Window window = correlation_.window_at(u, v);
        Plane& plane = planes_[index(u, v)];
        float& cost = costs_[index(u, v)];
        const auto attempt = [&](const Plane& candidate) {
            if (!is_plausible(candidate)) return;
            const float found = correlation_.score(window, u, v, candidate).cost;
            if (found >= cost) return;
            cost = found;
            plane = candidate;
        };
        for (const int apart : {1, 4}) {
            for (const bool along_u : {true, false}) {
                const int x = along_u ? u + way * apart : u, y = along_u ? v : v + way * apart;
                if (x < 0 || y < 0 || x >= rig_.width_px || y >= rig_.height_px) continue;
                const Plane& there = planes_[index(x, y)];
                if (there.disparity_px <= 0.0F) continue;
                attempt(there.moved(u - x, v - y));
            }
        }
        attempt({0.5F * (min_disparity_px_ + max_disparity_px_ +
                         random_at(u, v, round) * (max_disparity_px_ - min_disparity_px_)),
                 0.0F,
                 0.0F});
        if (cost >= 1.0F) return;
        float reach = 0.5F;
        for (int i = 0; i < 3; ++i, reach *= 0.4F) {
            Plane moved = plane;
            moved.disparity_px += reach * random_at(u, v, 16 * round + 4 * i + 5);
            attempt(moved);
            moved = plane;
            moved.slope_u += 0.2F * reach * random_at(u, v, 16 * round + 4 * i + 6);
            moved.slope_v += 0.2F * reach * random_at(u, v, 16 * round + 4 * i + 7);
            attempt(moved);
        }
    }

    // Keeps what is a peak of the correlation and connected with enough others.
    void accept() {
        accepted_ = cv::Mat::zeros(rig_.height_px, rig_.width_px, CV_32F);
        sigmas_ = cv::Mat::zeros(rig_.height_px, rig_.width_px, CV_32F);
        for (int v = 0; v < rig_.height_px; ++v)
            for (int u = 0; u < rig_.width_px; ++u) {
                const std::size_t at = index(u, v);
                if (known_[at] != 0) {
                    accepted_.at<float>(v, u) = planes_[at].disparity_px;
                } else if (has_texture_[at] != 0 && costs_[at] <= 1.0F - kMinCorrelation) {
                    const float sigma_px = correlation_.sigma_px(u, v, planes_[at]);
                    if (sigma_px * static_cast<float>(step_px_) > kMaxSigma_full_px) continue;
                    accepted_.at<float>(v, u) = planes_[at].disparity_px;
                    sigmas_.at<float>(v, u) = sigma_px;
                }
            }
        remove_speckles(accepted_, kMinIsland_px, 0.7F);
    }

    int write(types::DepthMap& depth) const {
        int num_filled = 0;
        const auto step = static_cast<float>(step_px_);
        for (int v = 0; v < rig_.height_px * step_px_; ++v)
            for (int u = 0; u < rig_.width_px * step_px_; ++u) {
                float& disparity = depth.disparity_px.at<float>(v, u);
                const int x = u / step_px_, y = v / step_px_;
                const float sigma = sigmas_.at<float>(y, x);
                if (disparity > 0.0F || sigma <= 0.0F || accepted_.at<float>(y, x) <= 0.0F)
                    continue;
                const Plane& plane = planes_[index(x, y)];
                const float du =
                    (static_cast<float>(u) + 0.5F) / step - 0.5F - static_cast<float>(x);
                const float dv =
                    (static_cast<float>(v) + 0.5F) / step - 0.5F - static_cast<float>(y);
                disparity = step * (plane.disparity_px + plane.slope_u * du + plane.slope_v * dv);
                depth.sigma_disparity_px.at<float>(v, u) = step * sigma;
                ++num_filled;
            }
        return num_filled;
    }

    PlaneCorrelation correlation_;
    types::RectifiedRig rig_;  // reduced
    int step_px_;
    float min_disparity_px_ = 0.0F;
    float max_disparity_px_ = 0.0F;
    std::vector<Plane> planes_;
    std::vector<float> costs_;
    std::vector<std::uint8_t> known_;
    std::vector<std::uint8_t> has_texture_;  // of the holes
    cv::Mat accepted_;                       // CV_32F disparity, known and filled; 0: neither
    cv::Mat sigmas_;                         // CV_32F, of what is filled
};

}  // namespace

int fill_from_views(const types::RectifiedRig& rig,
                    const cv::Mat& left,
                    std::span<const NeighbourView> neighbours,
                    types::DepthMap& depth) {
    const int step_px = std::max(1, (rig.width_px + kWidth_px / 2) / kWidth_px);
    if (neighbours.size() < PlaneCorrelation::kNumViews ||
        rig.width_px / step_px <= 2 * kMargin_px || rig.height_px / step_px <= 2 * kMargin_px ||
        depth.disparity_px.empty())
        return 0;
    return HoleFiller(rig, left, neighbours, step_px).fill(depth);
}

}  // namespace divemesh::stereo
