#include "worker/features/track_features.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "worker/features/align_patch.hpp"

namespace divemesh::features {
namespace {

constexpr double kBackwardError_px = 0.5;
constexpr double kMinCorrelation = 0.7;
constexpr double kSameCorrelation = 0.8;  // with the reference patch
constexpr int kMinCell_px = 8;
constexpr int kBorder_px = 10;           // a patch and one more pixel
constexpr float kCornerQuality = 0.01F;  // of the best corner of the image

Eigen::Vector3d expected(const types::RectifiedRig& rig,
                         const types::Feature& feature,
                         const Eigen::Isometry3d& T_cam_previous) {
    const Eigen::Vector3d p_previous =
        types::has_depth(feature) ? types::point_cam(rig, feature)
                                  : rig.point_cam(feature.pixel.x(), feature.pixel.y(), 1.0);
    const Eigen::Vector3d p_cam = types::has_depth(feature)
                                      ? Eigen::Vector3d(T_cam_previous * p_previous)
                                      : Eigen::Vector3d(T_cam_previous.linear() * p_previous);
    if (p_cam.z() < 1e-3) return types::measurement_px(feature);
    Eigen::Vector3d result = types::project_px(rig, p_cam);
    if (!types::has_depth(feature)) result.z() = 0.0;
    return result;
}

bool inside(const cv::Mat& image, const Eigen::Vector2d& pixel) {
    return pixel.minCoeff() >= kBorder_px && pixel.x() < image.cols - kBorder_px &&
           pixel.y() < image.rows - kBorder_px;
}

// A mask that keeps later features off earlier ones: where tracks merge, the older one stays.
class Occupancy {
public:
    Occupancy(const cv::Mat& image, int cell_px)
        : cell_px_(cell_px),
          taken_((image.rows - 1) / cell_px + 1, (image.cols - 1) / cell_px + 1) {
        taken_ = 0;
    }
    bool take(double x, double y) {
        std::uint8_t& taken =
            taken_(static_cast<int>(y) / cell_px_, static_cast<int>(x) / cell_px_);
        const bool free = taken == 0;
        taken = 1;
        return free;
    }

private:
    int cell_px_;
    cv::Mat_<std::uint8_t> taken_;
};

}  // namespace

FeatureTracker::FeatureTracker(const types::RectifiedRig& rig, int num_features)
    : rig_(rig),
      cell_px_(std::max(kMinCell_px,
                        static_cast<int>(std::sqrt(rig.width_px * rig.height_px /
                                                   static_cast<double>(num_features))))),
      lost_(rig) {}

types::Features FeatureTracker::track(const cv::Mat& left,
                                      const types::Features& previous,
                                      const Eigen::Isometry3d& T_cam_previous) {
    wide_ = false;
    std::swap(previous_pyramid_, current_pyramid_);
    high_pass_.apply(left, current_pyramid_[0]);
    for (std::size_t i = 1; i < kNumLevels; ++i)
        cv::pyrDown(current_pyramid_[i - 1], current_pyramid_[i]);
    types::Features features;
    if (previous_pyramid_[0].empty()) return features;
    previous_patches_ = std::exchange(reference_patches_, {});
    Occupancy occupancy(left, min_distance_px());
    for (const types::Feature& feature : previous) {
        const Eigen::Vector3d guess = expected(rig_, feature, T_cam_previous);
        const Eigen::Vector2d near = track_coarse(feature.pixel, guess.head<2>());
        const auto known = previous_patches_.find(feature.id);
        std::optional<Patch> reference_patch;
        if (known != previous_patches_.end())
            reference_patch = known->second.warp_to_current(rig_, T_cam_previous);
        const auto seen =
            track_fine(feature.pixel, near, reference_patch ? &*reference_patch : nullptr);
        if (!seen && known != previous_patches_.end() && types::has_depth(feature))
            lost_.lose(feature, known->second);
        if (!seen || !occupancy.take(seen->pixel.x(), seen->pixel.y())) continue;
        features.push_back({feature.id, seen->pixel, guess.z()});
        if (seen->matches_reference) {
            reference_patches_.emplace(feature.id, known->second)
                .first->second.move(T_cam_previous);
        } else {
            ReferencePatch updated =
                known == previous_patches_.end()
                    ? ReferencePatch(rig_, previous_pyramid_[0], feature)
                    : ReferencePatch(rig_, previous_pyramid_[0], feature, known->second);
            updated.move(T_cam_previous);
            reference_patches_.emplace(feature.id, std::move(updated));
        }
    }
    return features;
}

types::Features FeatureTracker::track_again(const types::Features& previous,
                                            const Eigen::Isometry3d& T_cam_previous) {
    wide_ = true;
    lost_.forget_newest();
    reference_patches_.clear();
    Occupancy occupancy(current_pyramid_[0], min_distance_px());
    types::Features features;
    for (const types::Feature& feature : previous) {
        if (!types::has_depth(feature)) continue;
        const auto known = previous_patches_.find(feature.id);
        const ReferencePatch* reference =
            known == previous_patches_.end() ? nullptr : &known->second;
        const ReferencePatch before =
            reference ? ReferencePatch(rig_, previous_pyramid_[0], feature, *reference)
                      : ReferencePatch(rig_, previous_pyramid_[0], feature);
        const auto seen = track_warped(feature, T_cam_previous, reference, before);
        if (!seen && reference) lost_.lose(feature, *reference);
        if (!seen || !occupancy.take(seen->pixel.x(), seen->pixel.y())) continue;
        features.push_back({feature.id, seen->pixel, expected(rig_, feature, T_cam_previous).z()});
        reference_patches_.emplace(feature.id, seen->matches_reference ? *reference : before)
            .first->second.move(T_cam_previous);
    }
    return features;
}

types::Features FeatureTracker::find_lost(const Eigen::Isometry3d& T_cam_previous,
                                          const types::Features& present) {
    Occupancy occupancy(current_pyramid_[0], min_distance_px());
    for (const types::Feature& feature : present)
        occupancy.take(feature.pixel.x(), feature.pixel.y());
    types::Features features;
    for (const LostFeatures::Found& found : lost_.find(current_pyramid_[0], T_cam_previous)) {
        const Eigen::Vector2d& pixel = found.feature.pixel;
        if (!inside(current_pyramid_[0], pixel) || !occupancy.take(pixel.x(), pixel.y())) continue;
        features.push_back(found.feature);
        reference_patches_.emplace(found.feature.id, found.reference);
    }
    return features;
}

// Returns the position found by the coarser levels of the pyramids.
Eigen::Vector2d FeatureTracker::track_coarse(const Eigen::Vector2d& from,
                                             const Eigen::Vector2d& guess) const {
    Eigen::Vector2d there = guess;
    for (std::size_t level = kNumLevels - 1; level > 0; --level) {
        const double scale = 1 << level;
        const auto patch = Patch::read(previous_pyramid_[level], from / scale);
        const auto found =
            patch ? patch->align(current_pyramid_[level], there / scale) : std::nullopt;
        if (found && found->correlation >= kMinCorrelation) there = found->pixel * scale;
    }
    return there;
}

std::optional<FeatureTracker::Seen> FeatureTracker::track_fine(const Eigen::Vector2d& from,
                                                               const Eigen::Vector2d& near,
                                                               const Patch* reference_patch) const {
    std::optional<Seen> seen;
    const auto look_for = [&](const Patch& look, double min_correlation) {
        const auto found = look.align(current_pyramid_[0], near);
        if (found && found->correlation >= min_correlation)
            seen = Seen{found->pixel, &look == reference_patch};
    };
    if (reference_patch != nullptr) look_for(*reference_patch, kSameCorrelation);
    if (!seen)
        if (const auto previous_patch = Patch::read(previous_pyramid_[0], from))
            look_for(*previous_patch, kMinCorrelation);
    if (!seen || !inside(current_pyramid_[0], seen->pixel)) return std::nullopt;
    const auto current_patch = Patch::read(current_pyramid_[0], seen->pixel);
    const auto back =
        current_patch ? current_patch->align(previous_pyramid_[0], from) : std::nullopt;
    if (!back || (back->pixel - from).norm() > kBackwardError_px) return std::nullopt;
    return seen;
}

std::optional<FeatureTracker::Seen> FeatureTracker::track_warped(
    const types::Feature& feature,
    const Eigen::Isometry3d& T_cam_previous,
    const ReferencePatch* reference,
    const ReferencePatch& before) const {
    const auto warp = before.warp(rig_, T_cam_previous);
    if (!warp) return std::nullopt;
    const Eigen::Vector2d guess = expected(rig_, feature, T_cam_previous).head<2>();
    std::optional<Seen> seen;
    const auto look_for = [&](const ReferencePatch& look) {
        const auto patch = look.warp_to_current(rig_, T_cam_previous);
        const auto found = patch ? patch->align(current_pyramid_[0], guess) : std::nullopt;
        if (found && found->correlation >= kSameCorrelation)
            seen = Seen{found->pixel, &look == reference};
    };
    if (reference != nullptr) look_for(*reference);
    if (!seen) look_for(before);
    if (!seen || !inside(current_pyramid_[0], seen->pixel)) return std::nullopt;
    const auto current_patch = Patch::read(current_pyramid_[0], seen->pixel, warp->inverse());
    const auto back =
        current_patch ? current_patch->align(previous_pyramid_[0], feature.pixel) : std::nullopt;
    if (!back || (back->pixel - feature.pixel).norm() > kBackwardError_px) return std::nullopt;
    return seen;
}

types::Features FeatureTracker::detect(const types::Features& present,
                                       const cv::Mat& fixed_pattern) {
    const cv::Mat& left = current_pyramid_[0];
    const int cell_px = wide_ ? std::max(kMinCell_px, cell_px_ * 2 / 3) : cell_px_;
    cv::Mat scores = corner_scores_.of(left);
    if (!fixed_pattern.empty()) scores.setTo(0.0F, fixed_pattern);
    double best = 0.0;
    cv::minMaxLoc(scores, nullptr, &best);
    const float threshold =
        std::max(CornerScores::kNoise, kCornerQuality * static_cast<float>(best));
    Occupancy occupancy(left, cell_px);
    for (const types::Feature& feature : present)
        occupancy.take(feature.pixel.x(), feature.pixel.y());
    types::Features features;
    for (const cv::Point& at : best_of_cells(scores, threshold, kBorder_px, cell_px))
        if (occupancy.take(at.x, at.y)) features.push_back({next_id_++, {at.x, at.y}, 0.0});
    return features;
}

}  // namespace divemesh::features
