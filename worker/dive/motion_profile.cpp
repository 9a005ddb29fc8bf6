#include "worker/dive/motion_profile.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "worker/base/seconds.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::dive {
namespace {

constexpr int kProfileWidth_px = 320;  // corners are followed in images this wide
constexpr int kMaxCorners = 80;
constexpr int kMinCorners = 10;
constexpr std::size_t kMinOverlap = 20;   // samples that two profiles share at a lag
constexpr double kMinOverlapShare = 0.4;  // of the shorter profile
constexpr double kMinCorrelation = 0.8;   // pairs of real rigs have 0.83 to 1
constexpr double kMinLead = 0.1;          // of the best correlation over the runner-up
constexpr double kClearPeriods = 3.0;     // lags that differ by more are other lags

cv::Mat reduced_to_profile(const cv::Mat& image) {
    if (image.empty() || image.cols <= kProfileWidth_px) return image;
    cv::Mat small;
    const double scale = static_cast<double>(kProfileWidth_px) / image.cols;
    cv::resize(image, small, {}, scale, scale, cv::INTER_AREA);
    return small;
}

std::optional<Eigen::Vector2d> median_flow_px(const cv::Mat& from, const cv::Mat& to) {
    std::vector<cv::Point2f> corners;
    std::vector<cv::Point2f> moved;
    std::vector<unsigned char> found;
    if (from.empty() || to.empty()) return std::nullopt;
    cv::goodFeaturesToTrack(from, corners, kMaxCorners, 0.02, 8.0);
    if (corners.size() < kMinCorners) return std::nullopt;
    cv::calcOpticalFlowPyrLK(from, to, corners, moved, found, cv::noArray(), {15, 15}, 3);
    std::vector<double> x;
    std::vector<double> y;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        if (found[i] == 0) continue;
        x.push_back(moved[i].x - corners[i].x);
        y.push_back(moved[i].y - corners[i].y);
    }
    if (x.size() < kMinCorners) return std::nullopt;
    return Eigen::Vector2d(stats::upper_median(std::move(x)), stats::upper_median(std::move(y)));
}

double median_period_s(const MotionProfile& profile) {
    std::vector<double> periods;
    for (std::size_t i = 1; i < profile.size(); ++i)
        periods.push_back(profile[i].time_s - profile[i - 1].time_s);
    return stats::upper_median(std::move(periods));
}

// Returns the flow at a time, linear between samples at most 2.5 periods apart.
std::optional<Eigen::Vector2d> flow_at(const MotionProfile& profile,
                                       double time_s,
                                       double period_s) {
    const auto after = std::lower_bound(
        profile.begin(), profile.end(), time_s, [](const MotionSample& s, double time) {
            return s.time_s < time;
        });
    if (after == profile.begin() || after == profile.end()) return std::nullopt;
    const auto before = after - 1;
    const double interval_s = after->time_s - before->time_s;
    if (interval_s > 2.5 * period_s) return std::nullopt;
    const double share = (time_s - before->time_s) / interval_s;
    return (1.0 - share) * before->flow_1_s + share * after->flow_1_s;
}

// Returns the correlation of both components together, each about its mean.
std::optional<double> correlation_at(const MotionProfile& left,
                                     const MotionProfile& right,
                                     double lag_s,
                                     double period_s) {
    std::vector<Eigen::Vector2d> a;
    std::vector<Eigen::Vector2d> b;
    for (const MotionSample& sample : left)
        if (const auto flow = flow_at(right, sample.time_s + lag_s, period_s)) {
            a.push_back(sample.flow_1_s);
            b.push_back(*flow);
        }
    const auto shorter = static_cast<double>(std::min(left.size(), right.size()));
    if (a.size() < kMinOverlap || static_cast<double>(a.size()) < kMinOverlapShare * shorter)
        return std::nullopt;
    Eigen::Vector2d mean_a = Eigen::Vector2d::Zero();
    Eigen::Vector2d mean_b = Eigen::Vector2d::Zero();
    for (std::size_t i = 0; i < a.size(); ++i) {
        mean_a += a[i] / static_cast<double>(a.size());
        mean_b += b[i] / static_cast<double>(a.size());
    }
    double ab = 0.0;
    double aa = 1e-12;
    double bb = 1e-12;
    for (std::size_t i = 0; i < a.size(); ++i) {
        ab += (a[i] - mean_a).dot(b[i] - mean_b);
        aa += (a[i] - mean_a).squaredNorm();
        bb += (b[i] - mean_b).squaredNorm();
    }
    return ab / std::sqrt(aa * bb);
}

}  // namespace

bool ProfileLag::is_clear() const {
    return correlation > kMinCorrelation && correlation - runner_up > kMinLead;
}

MotionProfile motion_profile(const std::vector<std::int64_t>& timestamps_ns,
                             std::int64_t start_ns,
                             const std::function<cv::Mat(std::size_t index)>& load) {
    MotionProfile profile;
    cv::Mat before;
    for (std::size_t i = 0; i < timestamps_ns.size(); ++i) {
        cv::Mat image = reduced_to_profile(load(i));
        const auto flow_px = i > 0 ? median_flow_px(before, image) : std::nullopt;
        before = image;
        if (!flow_px) continue;
        const double begin_s = base::to_s(timestamps_ns[i - 1] - start_ns);
        const double end_s = base::to_s(timestamps_ns[i] - start_ns);
        profile.push_back({0.5 * (begin_s + end_s), *flow_px / ((end_s - begin_s) * image.cols)});
    }
    return profile;
}

std::optional<ProfileLag> find_lag(const MotionProfile& left,
                                   const MotionProfile& right,
                                   double max_lag_s) {
    if (left.size() < kMinOverlap || right.size() < kMinOverlap) return std::nullopt;
    const double period_s = std::max(median_period_s(left), median_period_s(right));
    const double step_s = 0.25 * period_s;
    const int num_steps = static_cast<int>(max_lag_s / step_s);
    std::vector<std::pair<double, double>> tried;  // lag, correlation
    ProfileLag best;
    for (int i = -num_steps; i <= num_steps; ++i) {
        const auto correlation = correlation_at(left, right, i * step_s, period_s);
        if (!correlation) continue;
        tried.emplace_back(i * step_s, *correlation);
        if (tried.size() == 1 || *correlation > best.correlation)
            best = {i * step_s, *correlation, 0.0};
    }
    if (tried.empty()) return std::nullopt;
    for (const auto& [lag_s, correlation] : tried)
        if (std::abs(lag_s - best.lag_s) > kClearPeriods * period_s)
            best.runner_up = std::max(best.runner_up, correlation);
    return best;
}

}  // namespace divemesh::dive
