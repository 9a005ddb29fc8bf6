#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "worker/features/patch_kernels.hpp"

namespace divemesh::features {

// A square of picture around a point, read between the pixels, with its gradients: what is looked
// for in another picture. Its brightness and contrast may differ there.
class Patch {
public:
    static constexpr double kRadius_px = 0.5 * kPatchSide_px;

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
    // Gauss-Newton (Baker and Matthews 2004). With T the patch, g its gradient, what is seen at
    // the present place is
    //
    //     I(x) = a (T(x) + g(x) s) + b
    //
    // linear in (a s, a, b): a and b are eliminated from the normal equations, and a s is divided
    // by the ratio of the contrasts, which far from the place is a steadier gain than a. The place
    // moves by -s. Nothing when it leaves the picture, runs away, or when
    // noise alone would move the place too far.
    std::optional<Alignment> align(const cv::Mat& image, const Eigen::Vector2d& start) const;

private:
    explicit Patch(const std::int16_t* outer);
    bool has_contrast() const;

    PatchColumns columns_;
    // Of the columns' products, once gain and bias are eliminated:
    Eigen::Matrix2d hessian_;    // of s
    Eigen::Matrix2d mixed_;      // gradients by (value, 1)
    Eigen::Matrix2d light_;      // inverse of (value, 1) by (value, 1)
    double squared_norm_ = 0.0;  // of the value, mean-free
    double sum_ = 0.0;           // of the value
};

}  // namespace divemesh::features
