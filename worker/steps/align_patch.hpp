#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core/mat.hpp>
#include <optional>

namespace divemesh::worker {

// A square of picture around a point, read between the pixels, with its gradients: what is looked
// for in another picture. Its brightness and contrast may differ there.
class Patch {
public:
    static constexpr int kRadius_px = 6;
    static constexpr int kSide_px = 2 * kRadius_px + 1;
    static constexpr int kNumPixels = kSide_px * kSide_px;

    // Patch coordinates to picture: pixel = centre + warp * offset. Nothing when it leaves the
    // picture or has no contrast.
    static std::optional<Patch> read(const cv::Mat& image,
                                     const Eigen::Vector2d& centre,
                                     const Eigen::Matrix2d& warp = Eigen::Matrix2d::Identity());

    struct Alignment {
        Eigen::Vector2d pixel;
        double correlation = 0.0;  // zero-mean, normalised; 1: the same
    };
    // The place in `image` nearest to `start` that looks like the patch, by inverse compositional
    // Gauss-Newton (Baker and Matthews 2004) on mean-free, contrast-free values. `along_row` keeps
    // v. Nothing when it leaves the picture or runs away.
    std::optional<Alignment> align(const cv::Mat& image,
                                   const Eigen::Vector2d& start,
                                   bool along_row) const;

private:
    std::array<float, kNumPixels> value_{};  // mean 0, norm 1
    std::array<float, kNumPixels> gradient_x_{};
    std::array<float, kNumPixels> gradient_y_{};
    Eigen::Matrix2d hessian_ = Eigen::Matrix2d::Zero();
};

}  // namespace divemesh::worker
