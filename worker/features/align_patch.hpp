#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "worker/features/patch_kernels.hpp"

namespace divemesh::features {

// A square patch of an image around a point, interpolated between pixels, with its gradients, to be
// aligned with another image. Brightness and contrast may differ there.
class Patch {
public:
    static constexpr double kRadius_px = 0.5 * kPatchSide_px;

    // Reads the patch; patch coordinates map to the image by pixel = centre + warp * offset.
    // nullopt if it leaves the image or has no contrast.
    static std::optional<Patch> read(const cv::Mat& image,
                                     const Eigen::Vector2d& centre,
                                     const Eigen::Matrix2d& warp = Eigen::Matrix2d::Identity());

    struct Alignment {
        Eigen::Vector2d pixel;
        double correlation = 0.0;  // zero-mean, normalised; 1: the same
    };
    // Returns the position nearest to `start` in `image` that matches the patch, by inverse
    // compositional Gauss-Newton (Baker and Matthews 2004). With T the patch, g its gradient, the
    // image at the current position is
    //
    //     I(x) = a (T(x) + g(x) s) + b
    //
    // linear in (a s, a, b): a and b are eliminated from the normal equations, and a s is divided
    // by the ratio of the contrasts, which is a more stable gain than a far from the match. The
    // position moves by -s. nullopt if the patch leaves the image, the search diverges, or image
    // noise alone would move the position too far.
    std::optional<Alignment> align(const cv::Mat& image, const Eigen::Vector2d& start) const;

private:
    explicit Patch(const std::int16_t* outer);
    bool has_contrast() const;

    PatchColumns columns_;
    // Products of the columns, after gain and bias are eliminated:
    Eigen::Matrix2d hessian_;    // of s
    Eigen::Matrix2d mixed_;      // gradients by (value, 1)
    Eigen::Matrix2d light_;      // inverse of (value, 1) by (value, 1)
    double squared_norm_ = 0.0;  // of the value, mean-free
    double sum_ = 0.0;           // of the value
};

}  // namespace divemesh::features
