#include "worker/stereo/fill_from_views.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "worker/stereo/disparity_sigma.hpp"
#include "worker/stereo/speckles.hpp"

namespace divemesh::stereo {
namespace {

// All sizes, disparities and gradients are those of the reduced image, unless they are named full.
constexpr int kWidth_px = 400;
constexpr int kReach = 2;  // of the window, in samples
constexpr int kStride_px = 2;
constexpr int kSide = 2 * kReach + 1;
constexpr int kNumSamples = kSide * kSide;
constexpr int kMargin_px = kReach * kStride_px;
constexpr int kNumViews = 2;  // that have to show a surface
constexpr int kNumRounds = 4;
constexpr float kMinCorrelation = 0.8F;
constexpr float kMinTexture = 2.0F;     // standard deviation of the window over that of the noise
constexpr float kMinPeak = 0.02F;       // loss of correlation at 1 px
constexpr float kSimilar_grey = 20.0F;  // grey difference at which a sample counts 1/e
constexpr float kMaxSlope = 0.7F;       // of disparity per pixel
constexpr float kMinSigma_px = 0.3F;    // along the neighbour's epipolar line
constexpr float kMaxSigma_full_px = 3.0F;
constexpr float kMinDepth = 0.01F;  // in a neighbour, of the depth in the image to fill
constexpr float kWorst = 2.0F;
constexpr int kMinIsland_px = 40;

// Where the samples of a window are, from its centre.
struct Offsets {
    std::array<float, kNumSamples> u;
    std::array<float, kNumSamples> v;
};
constexpr Offsets kOffsets = [] {
    Offsets offsets{};
    std::size_t i = 0;
    for (int dv = -kMargin_px; dv <= kMargin_px; dv += kStride_px)
        for (int du = -kMargin_px; du <= kMargin_px; du += kStride_px, ++i) {
            offsets.u[i] = static_cast<float>(du);
            offsets.v[i] = static_cast<float>(dv);
        }
    return offsets;
}();

// A plane is linear in disparity.
struct Plane {
    float disparity_px = 0.0F;
    float slope_u = 0.0F;
    float slope_v = 0.0F;

    // The same plane at another pixel.
    Plane moved(int du, int dv) const {
        const float there_px =
            disparity_px + slope_u * static_cast<float>(du) + slope_v * static_cast<float>(dv);
        return {there_px, slope_u, slope_v};
    }
};

types::RectifiedRig reduced(types::RectifiedRig rig, int step_px) {
    rig.width_px /= step_px;
    rig.height_px /= step_px;
    rig.focal_px /= step_px;
    rig.cx_px = (rig.cx_px + 0.5) / step_px - 0.5;
    rig.cy_px = (rig.cy_px + 0.5) / step_px - 0.5;
    return rig;
}

cv::Mat reduced(const cv::Mat& image, const types::RectifiedRig& rig, int step_px) {
    cv::Mat small, values;
    const cv::Size size(rig.width_px, rig.height_px);
    cv::resize(image(cv::Rect({}, size * step_px)), small, size, 0.0, 0.0, cv::INTER_AREA);
    small.convertTo(values, CV_32F);
    return values;
}

// Returns a number that depends on the pixel and the round alone, -1 to 1.
float hashed(int u, int v, int round) {
    auto h = static_cast<std::uint32_t>(u) * 0x9E3779B1U ^
             static_cast<std::uint32_t>(v) * 0x85EBCA77U ^
             static_cast<std::uint32_t>(round) * 0xC2B2AE3DU;
    h ^= h >> 15;
    h *= 0x2C1B3C6DU;
    h ^= h >> 12;
    h *= 0x297A2D39U;
    h ^= h >> 15;
    return static_cast<float>(h) / 2147483648.0F - 1.0F;
}

// The window around a pixel: the samples, their weights and moments.
struct Window {
    std::array<float, kNumSamples> value;
    std::array<float, kNumSamples> weight;
    float mean = 0.0F;
    float variance = 0.0F;
};

class HoleFiller {
public:
    HoleFiller(const types::RectifiedRig& rig,
               const cv::Mat& left,
               std::span<const NeighbourView> neighbours,
               int step_px)
        : rig_(reduced(rig, step_px)), step_px_(step_px), left_(reduced(left, rig_, step_px)) {
        for (const NeighbourView& neighbour : neighbours) {
            views_.push_back(reduced(neighbour.left, rig_, step_px));
            projections_.emplace_back(rig_, neighbour.T_other_cam);
        }
        cv::Mat grey;
        left_.convertTo(grey, CV_8U);
        min_deviation_ = kMinTexture * static_cast<float>(std::max(0.5, image_noise(grey)));
    }

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
        costs_.assign(planes_.size(), kWorst);
        has_texture_.assign(planes_.size(), 0);
        for (int v = kMargin_px; v < rig_.height_px - kMargin_px; ++v)
            for (int u = kMargin_px; u < rig_.width_px - kMargin_px; ++u) {
                if (known_[index(u, v)] != 0) continue;
                const Window window = window_at(u, v);
                if (window.variance >= min_deviation_ * min_deviation_)
                    has_texture_[index(u, v)] = 1;
            }
    }

    Window window_at(int u, int v) const {
        Window window;
        const float center = left_.at<float>(v, u);
        float sum = 0.0F, weights = 0.0F;
        int i = 0;
        for (int dv = -kMargin_px; dv <= kMargin_px; dv += kStride_px)
            for (int du = -kMargin_px; du <= kMargin_px; du += kStride_px, ++i) {
                const float value = left_.at<float>(v + dv, u + du);
                const float weight = std::exp(-std::abs(value - center) / kSimilar_grey);
                window.value[i] = value;
                window.weight[i] = weight;
                sum += weight * value;
                weights += weight;
            }
        window.mean = sum / weights;
        float squares = 0.0F;
        for (i = 0; i < kNumSamples; ++i) {
            window.weight[i] /= weights;
            window.value[i] -= window.mean;
            squares += window.weight[i] * window.value[i] * window.value[i];
        }
        window.variance = squares;
        return window;
    }

    // Returns 1 - correlation of the window with what a view shows of the plane; kWorst if a part
    // is out of sight.
    float cost_in(std::size_t view, const Window& window, int u, int v, const Plane& plane) const {
        const cv::Mat& image = views_[view];
        std::array<float, kNumSamples> across, down;
        if (!project(projections_[view], u, v, plane, image.size(), across, down)) return kWorst;
        float sum = 0.0F, squares = 0.0F, product = 0.0F;
        for (std::size_t i = 0; i < kNumSamples; ++i) {
            const int left = static_cast<int>(across[i]), top = static_cast<int>(down[i]);
            const float p = across[i] - static_cast<float>(left);
            const float q = down[i] - static_cast<float>(top);
            const float* above = image.ptr<float>(top) + left;
            const float* below = image.ptr<float>(top + 1) + left;
            const float value = (1.0F - q) * ((1.0F - p) * above[0] + p * above[1]) +
                                q * ((1.0F - p) * below[0] + p * below[1]);
            const float weighted = window.weight[i] * value;
            sum += weighted;
            squares += weighted * value;
            product += weighted * window.value[i];
        }
        const float variance = squares - sum * sum;
        if (variance < 0.25F * min_deviation_ * min_deviation_) return 1.0F;
        return 1.0F - product / std::sqrt(variance * window.variance);
    }

    // Maps the samples of the window to a view. Returns false if one is out of sight.
    static bool project(const ViewProjection& projection,
                        int u,
                        int v,
                        const Plane& plane,
                        cv::Size size,
                        std::array<float, kNumSamples>& across,
                        std::array<float, kNumSamples>& down) {
        const Eigen::Matrix3f& M = projection.M;
        const Eigen::Vector3f& m = projection.m;
        const Eigen::Vector3f from =
            M * Eigen::Vector3f(static_cast<float>(u), static_cast<float>(v), 1.0F) +
            m * plane.disparity_px;
        const Eigen::Vector3f step_u = M.col(0) + m * plane.slope_u;
        const Eigen::Vector3f step_v = M.col(1) + m * plane.slope_v;
        const auto max_u = static_cast<float>(size.width - 1);
        const auto max_v = static_cast<float>(size.height - 1);
        int num_seen = 0;
        for (std::size_t i = 0; i < kNumSamples; ++i) {
            const float du = kOffsets.u[i], dv = kOffsets.v[i];
            const float d = plane.disparity_px + plane.slope_u * du + plane.slope_v * dv;
            const float w = from.z() + step_u.z() * du + step_v.z() * dv;
            const float inverse = 1.0F / w;
            across[i] = (from.x() + step_u.x() * du + step_v.x() * dv) * inverse;
            down[i] = (from.y() + step_u.y() * du + step_v.y() * dv) * inverse;
            num_seen += static_cast<int>(d > 0.0F) & static_cast<int>(w > kMinDepth) &
                        static_cast<int>(across[i] >= 0.0F) & static_cast<int>(down[i] >= 0.0F) &
                        static_cast<int>(across[i] < max_u) & static_cast<int>(down[i] < max_v);
        }
        return num_seen == kNumSamples;
    }

    struct Score {
        float cost = kWorst;                         // mean of the best views
        std::array<std::size_t, kNumViews> views{};  // the best ones
    };

    Score score(const Window& window, int u, int v, const Plane& plane) const {
        std::array<float, kNumViews> best;
        best.fill(kWorst);
        Score result;
        for (std::size_t view = 0; view < views_.size(); ++view) {
            const float cost = cost_in(view, window, u, v, plane);
            if (cost < best[0]) {
                best[1] = best[0];
                result.views[1] = result.views[0];
                best[0] = cost;
                result.views[0] = view;
            } else if (cost < best[1]) {
                best[1] = cost;
                result.views[1] = view;
            }
        }
        result.cost = best[1] >= kWorst ? kWorst : 0.5F * (best[0] + best[1]);
        return result;
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
        const Window window = window_at(u, v);
        Plane& plane = planes_[index(u, v)];
        float& cost = costs_[index(u, v)];
        const auto attempt = [&](const Plane& candidate) {
            if (!is_plausible(candidate)) return;
            const float found = score(window, u, v, candidate).cost;
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
                         hashed(u, v, round) * (max_disparity_px_ - min_disparity_px_)),
                 0.0F,
                 0.0F});
        if (cost >= 1.0F) return;
        float reach = 0.5F;
        for (int i = 0; i < 3; ++i, reach *= 0.4F) {
            Plane moved = plane;
            moved.disparity_px += reach * hashed(u, v, 16 * round + 4 * i + 5);
            attempt(moved);
            moved = plane;
            moved.slope_u += 0.2F * reach * hashed(u, v, 16 * round + 4 * i + 6);
            moved.slope_v += 0.2F * reach * hashed(u, v, 16 * round + 4 * i + 7);
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
                    const float sigma_px = sigma_at(u, v);
                    if (sigma_px * static_cast<float>(step_px_) > kMaxSigma_full_px) continue;
                    accepted_.at<float>(v, u) = planes_[at].disparity_px;
                    sigmas_.at<float>(v, u) = sigma_px;
                }
            }
        remove_speckles(accepted_, kMinIsland_px, 0.7F);
    }

    // Returns the sigma of the disparity by the curvature of the correlation; infinite if there is
    // no peak.
    float sigma_at(int u, int v) const {
        constexpr float kNone = 1e9F;
        const Plane plane = planes_[index(u, v)];
        const Window window = window_at(u, v);
        const Score found = score(window, u, v, plane);
        const float shift = std::min(shift_px(found.views[0], u, v, plane.disparity_px),
                                     shift_px(found.views[1], u, v, plane.disparity_px));
        if (shift < 0.05F) return kNone;
        Plane nearer = plane, farther = plane;
        nearer.disparity_px += 1.0F / shift;
        farther.disparity_px -= 1.0F / shift;
        float losses[2] = {0.0F, 0.0F};
        for (const std::size_t view : found.views) {
            losses[0] += 0.5F * std::min(1.0F, cost_in(view, window, u, v, nearer));
            losses[1] += 0.5F * std::min(1.0F, cost_in(view, window, u, v, farther));
        }
        const float least = std::min(losses[0], losses[1]) - found.cost;
        if (least < kMinPeak) return kNone;
        const float curvature = losses[0] + losses[1] - 2.0F * found.cost;
        const float sigma_px =
            std::sqrt(2.0F * std::max(found.cost, 0.0F) / (0.5F * kNumSamples * curvature));
        return std::max(sigma_px, kMinSigma_px) / shift;
    }

    // Returns how far a pixel moves in a view per px of disparity.
    float shift_px(std::size_t view, int u, int v, float disparity_px) const {
        const ViewProjection& projection = projections_[view];
        const Eigen::Vector3f pixel(static_cast<float>(u), static_cast<float>(v), 1.0F);
        const Eigen::Vector3f here = projection.M * pixel + projection.m * disparity_px;
        const Eigen::Vector3f there = here + projection.m * 0.1F;
        return 10.0F * (here.hnormalized() - there.hnormalized()).norm();
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

    types::RectifiedRig rig_;
    int step_px_;
    cv::Mat left_;
    std::vector<cv::Mat> views_;  // CV_32F
    std::vector<ViewProjection> projections_;
    float min_deviation_ = 0.0F;
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
    if (neighbours.size() < kNumViews || rig.width_px / step_px <= 2 * kMargin_px ||
        rig.height_px / step_px <= 2 * kMargin_px || depth.disparity_px.empty())
        return 0;
    return HoleFiller(rig, left, neighbours, step_px).fill(depth);
}

}  // namespace divemesh::stereo
