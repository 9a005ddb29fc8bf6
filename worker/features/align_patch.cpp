#include "worker/features/align_patch.hpp"

#include <Eigen/LU>
#include <array>
#include <cmath>

namespace divemesh::features {
namespace {

constexpr int kMaxIterations = 10;
constexpr double kConverged_px = 0.03;  // step length; the next step would be a tenth of it
constexpr double kMaxDistance_px = 4.0;
constexpr double kMinGain = 0.1;
// Image noise in grey levels, and the largest position error it may cause.
constexpr double kNoise = 1.5;
constexpr double kUnsteady_px = 0.25;
constexpr double kMinHessian =
    (kNoise / kUnsteady_px) * (kNoise / kUnsteady_px) * kGreyLevel * kGreyLevel;
constexpr double kWeight = 32768.0;

using Outer = std::array<std::int16_t, kOuterPixels>;

const PatchKernels& kernels() {
    static const PatchKernels kChosen = patch_kernels(base::best_instructions());
    return kChosen;
}

// Returns the square of `side` pixels around `centre`; nullopt if it leaves the image.
std::optional<SquarePlace> place_of(const cv::Mat& image, const Eigen::Vector2d& centre, int side) {
    const Eigen::Vector2d corner = centre.array() - 0.5 * (side - 1);
    if (!(corner.x() >= 0.0 && corner.y() >= 0.0 && corner.x() < image.cols - side &&
          corner.y() < image.rows - side))
        return std::nullopt;
    const int column = static_cast<int>(corner.x());
    const int row = static_cast<int>(corner.y());
    return SquarePlace{image.ptr<std::uint8_t>(row) + column,
                       static_cast<std::ptrdiff_t>(image.step[0]),
                       static_cast<std::int16_t>(kWeight * (corner.x() - column)),
                       static_cast<std::int16_t>(kWeight * (corner.y() - row))};
}

bool read_warped(const cv::Mat& image,
                 const Eigen::Vector2d& centre,
                 const Eigen::Matrix2d& warp,
                 Outer& outer) {
    constexpr double kHalf = 0.5 * (kOuterSide_px - 1);
    const Eigen::Vector2d reach = kHalf * warp.cwiseAbs().rowwise().sum();
    if (!((centre - reach).minCoeff() >= 0.0 && centre.x() + reach.x() < image.cols - 1 &&
          centre.y() + reach.y() < image.rows - 1))
        return false;
    kernels().read_warped(
        {image.ptr<std::uint8_t>(), static_cast<std::ptrdiff_t>(image.step[0]), centre, warp},
        outer.data());
    return true;
}

}  // namespace

Patch::Patch(const std::int16_t* outer) {
    const ColumnProducts products = kernels().make_columns(outer, columns_);
    Eigen::Matrix2d light;
    light << products.value_value, products.value, products.value, kPatchPixels;
    sum_ = products.value;
    squared_norm_ = products.value_value - sum_ * sum_ / kPatchPixels;
    light_ = light.inverse();
    mixed_ << products.x_value, products.x, products.y_value, products.y;
    hessian_ << products.x_x, products.x_y, products.x_y, products.y_y;
    hessian_ -= mixed_ * light_ * mixed_.transpose();
}

bool Patch::has_contrast() const {  // 1 grey level RMS; below that is noise
    return squared_norm_ >= double{kPatchPixels} * kGreyLevel * kGreyLevel;
}

std::optional<Patch> Patch::read(const cv::Mat& image,
                                 const Eigen::Vector2d& centre,
                                 const Eigen::Matrix2d& warp) {
    Outer outer;
    if (warp.isIdentity(0.0)) {
        const auto place = place_of(image, centre, kOuterSide_px);
        if (!place) return std::nullopt;
        kernels().read_outer(*place, outer.data());
    } else if (!read_warped(image, centre, warp, outer)) {
        return std::nullopt;
    }
    std::optional<Patch> patch(Patch(outer.data()));
    if (!patch->has_contrast()) patch.reset();
    return patch;
}

std::optional<Patch::Alignment> Patch::align(const cv::Mat& image,
                                             const Eigen::Vector2d& start) const {
    const double half_trace = 0.5 * hessian_.trace();
    const double spread =
        std::sqrt(std::max(0.0, half_trace * half_trace - hessian_.determinant()));
    if (!(half_trace - spread >= kMinHessian)) return std::nullopt;
    const Eigen::Matrix2d inverse = hessian_.inverse();
    Alignment result{start, 0.0};
    for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
        const auto place = place_of(image, result.pixel, kPatchSide_px);
        if (!place) return std::nullopt;
        const SeenProducts seen = kernels().compare(columns_, *place);
        const Eigen::Vector2d by_light(seen.value_seen, seen.seen);
        const Eigen::Vector2d by_gradient =
            Eigen::Vector2d(seen.x_seen, seen.y_seen) - mixed_ * (light_ * by_light);
        const double sum = seen.seen;
        const double squared_norm = seen.seen_seen - sum * sum / kPatchPixels;
        const double gain = std::sqrt(squared_norm / squared_norm_);
        if (!(gain >= kMinGain)) return std::nullopt;
        result.correlation = (seen.value_seen - sum_ * sum / kPatchPixels) / (gain * squared_norm_);
        const Eigen::Vector2d step = inverse * by_gradient / gain;
        result.pixel -= step;
        if ((result.pixel - start).squaredNorm() > kMaxDistance_px * kMaxDistance_px)
            return std::nullopt;
        if (step.squaredNorm() < kConverged_px * kConverged_px) break;
    }
    return result;
}

}  // namespace divemesh::features
