#include "worker/features/described_image.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "worker/features/align_patch.hpp"

namespace divemesh::features {
namespace {

constexpr int kDescribedWidth_px = 720;
constexpr float kMaxScaleRatio = 1.5F;  // a level of the pyramid
constexpr int kMaxHammingDistance = 72;
constexpr double kRatio = 0.85;
constexpr float kOtherPlace_px = 8.0F;  // corners nearer than this show the same place
constexpr double kMinCorrelation = 0.9;
// How a surface that is not parallel to the images distorts a patch between them: stretched along
// the row, sheared across the rows. Without it, slanted edges would look like row offsets.
constexpr std::array<double, 3> kStretches = {1.0, 0.85, 1.15};
constexpr std::array<double, 5> kShears = {0.0, -0.15, 0.15, -0.3, 0.3};

// Pixel centres of the reduced image lie between those of the full one.
Eigen::Vector2d at_full_size(const Eigen::Vector2d& reduced_px, double scale) {
    return (reduced_px.array() + 0.5) * scale - 0.5;
}

struct Candidate {
    std::size_t index = 0;
    int distance = 0;
};

// Returns the nearest of the candidates; nullopt if it is far, or another place is nearly as near.
std::optional<std::size_t> distinct_nearest(const std::vector<Candidate>& candidates,
                                            const DescribedKeypoints& keypoints) {
    const auto nearest = std::ranges::min_element(candidates, {}, &Candidate::distance);
    if (nearest == candidates.end() || nearest->distance > kMaxHammingDistance) return std::nullopt;
    const DescribedKeypoint& best = keypoints[nearest->index];
    const bool ambiguous = std::ranges::any_of(candidates, [&](const Candidate& other) {
        const DescribedKeypoint& at = keypoints[other.index];
        return std::hypot(at.u_px - best.u_px, at.v_px - best.v_px) > kOtherPlace_px * best.scale &&
               nearest->distance >= kRatio * other.distance;
    });
    if (ambiguous) return std::nullopt;
    return nearest->index;
}

bool similar_scale(const DescribedKeypoint& a, const DescribedKeypoint& b) {
    return std::max(a.scale, b.scale) <= kMaxScaleRatio * std::min(a.scale, b.scale);
}

// Returns the alignment of the slant that correlates best.
std::optional<Eigen::Vector2d> aligned(const cv::Mat& a,
                                       const cv::Mat& b,
                                       const Eigen::Vector2d& of_a,
                                       const Eigen::Vector2d& start) {
    std::optional<Patch::Alignment> best;
    for (const double stretch : kStretches) {
        for (const double shear : kShears) {
            Eigen::Matrix2d warp = Eigen::Matrix2d::Identity();
            warp.row(0) << stretch, shear;
            const auto patch = Patch::read(a, of_a, warp);
            if (!patch) continue;
            const auto found = patch->align(b, start);
            if (found && (!best || found->correlation > best->correlation)) best = found;
        }
    }
    if (!best || best->correlation < kMinCorrelation) return std::nullopt;
    return best->pixel;
}

}  // namespace

Eigen::Vector2d DescribedImage::full_px(std::size_t index) const {
    return at_full_size(keypoint_px(index), scale);
}

DescribedImage describe_image(const cv::Mat& image) {
    DescribedImage result{image, image, 1.0, {}};
    if (image.cols > kDescribedWidth_px) {
        result.scale = static_cast<double>(image.cols) / kDescribedWidth_px;
        const cv::Size size(kDescribedWidth_px, cvRound(image.rows / result.scale));
        result.described = cv::Mat();  // not the full image's pixels
        cv::resize(image, result.described, size, 0.0, 0.0, cv::INTER_AREA);
    }
    result.keypoints = describe_keypoints(result.described);
    return result;
}

std::vector<IndexPair> mutual_nearest(
    const DescribedKeypoints& a,
    const DescribedKeypoints& b,
    const std::function<bool(const DescribedKeypoint& a, const DescribedKeypoint& b)>& may_match) {
    std::vector<std::vector<Candidate>> of_a(a.size());
    std::vector<std::vector<Candidate>> of_b(b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        for (std::size_t j = 0; j < b.size(); ++j) {
            if (!similar_scale(a[i], b[j]) || !may_match(a[i], b[j])) continue;
            const int distance = hamming_distance(a[i].descriptor, b[j].descriptor);
            of_a[i].push_back({j, distance});
            of_b[j].push_back({i, distance});
        }
    }
    std::vector<IndexPair> pairs;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const auto j = distinct_nearest(of_a[i], b);
        if (j && distinct_nearest(of_b[*j], a) == i) pairs.push_back({i, *j});
    }
    return pairs;
}

std::optional<Eigen::Vector2d> align_keypoint(const DescribedImage& a,
                                              std::size_t of_a,
                                              const DescribedImage& b,
                                              std::size_t of_b) {
    auto found = aligned(a.described, b.described, a.keypoint_px(of_a), b.keypoint_px(of_b));
    if (!found || a.scale == 1.0) return found;
    return aligned(a.full, b.full, a.full_px(of_a), at_full_size(*found, b.scale));
}

}  // namespace divemesh::features
