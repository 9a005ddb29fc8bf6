#include "worker/steps/align_patch.hpp"

#include <Eigen/LU>
#include <cmath>

namespace divemesh::worker {
namespace {

constexpr int kMaxIterations = 10;
constexpr double kConverged_px = 0.005;
constexpr double kFarthest_px = 4.0;

float bilinear(const cv::Mat& image, float x, float y) {
    const int column = static_cast<int>(x);
    const int row = static_cast<int>(y);
    const float right = x - static_cast<float>(column);
    const float below = y - static_cast<float>(row);
    const std::uint8_t* top = image.ptr<std::uint8_t>(row) + column;
    const std::uint8_t* bottom = top + image.step[0];
    const float upper =
        static_cast<float>(top[0]) + right * static_cast<float>(int{top[1]} - int{top[0]});
    const float lower =
        static_cast<float>(bottom[0]) + right * static_cast<float>(int{bottom[1]} - int{bottom[0]});
    return upper + below * (lower - upper);
}

bool inside(const cv::Mat& image, const Eigen::Vector2d& centre, double margin) {
    return centre.x() >= margin && centre.y() >= margin && centre.x() < image.cols - 1 - margin &&
           centre.y() < image.rows - 1 - margin;
}

// Unwarped reading: the four weights are the same for every pixel of the square.
template <int kSide>
void read_square(const cv::Mat& image, const Eigen::Vector2d& centre, float* values) {
    const double x0 = centre.x() - kSide / 2;
    const double y0 = centre.y() - kSide / 2;
    const int column = static_cast<int>(x0);
    const int row = static_cast<int>(y0);
    const auto right = static_cast<float>(x0 - column);
    const auto below = static_cast<float>(y0 - row);
    const float w00 = (1 - right) * (1 - below);
    const float w01 = right * (1 - below);
    const float w10 = (1 - right) * below;
    const float w11 = right * below;
    for (int v = 0; v < kSide; ++v) {
        const std::uint8_t* top = image.ptr<std::uint8_t>(row + v) + column;
        const std::uint8_t* bottom = top + image.step[0];
        for (int u = 0; u < kSide; ++u)
            values[v * kSide + u] =
                w00 * top[u] + w01 * top[u + 1] + w10 * bottom[u] + w11 * bottom[u + 1];
    }
}

// Takes away mean and contrast; false when there is no contrast.
bool normalise(std::array<float, Patch::kNumPixels>& values, float& norm) {
    float sum = 0.0F;
    for (const float value : values) sum += value;
    const float mean = sum / Patch::kNumPixels;
    float squares = 0.0F;
    for (float& value : values) {
        value -= mean;
        squares += value * value;
    }
    norm = std::sqrt(squares);
    if (norm < 1.0F * Patch::kSide_px) return false;  // 1 grey level RMS: noise
    for (float& value : values) value /= norm;
    return true;
}

}  // namespace

std::optional<Patch> Patch::read(const cv::Mat& image,
                                 const Eigen::Vector2d& centre,
                                 const Eigen::Matrix2d& warp) {
    constexpr int kOuter = kSide_px + 2;  // a ring more, for the gradients
    const double reach = (kRadius_px + 1) * warp.cwiseAbs().rowwise().sum().maxCoeff() + 1.0;
    if (!inside(image, centre, reach)) return std::nullopt;
    std::array<float, kOuter * kOuter> outer{};
    if (warp.isIdentity()) {
        read_square<kOuter>(image, centre, outer.data());
    } else {
        for (int v = 0; v < kOuter; ++v) {
            for (int u = 0; u < kOuter; ++u) {
                const Eigen::Vector2d pixel =
                    centre + warp * Eigen::Vector2d(u - kRadius_px - 1, v - kRadius_px - 1);
                outer[v * kOuter + u] =
                    bilinear(image, static_cast<float>(pixel.x()), static_cast<float>(pixel.y()));
            }
        }
    }
    Patch patch;
    for (int v = 0; v < kSide_px; ++v) {
        for (int u = 0; u < kSide_px; ++u) {
            const float* at = &outer[(v + 1) * kOuter + u + 1];
            patch.value_[v * kSide_px + u] = at[0];
            patch.gradient_x_[v * kSide_px + u] = 0.5F * (at[1] - at[-1]);
            patch.gradient_y_[v * kSide_px + u] = 0.5F * (at[kOuter] - at[-kOuter]);
        }
    }
    float norm = 0.0F;
    if (!normalise(patch.value_, norm)) return std::nullopt;
    for (int i = 0; i < kNumPixels; ++i) {
        patch.gradient_x_[i] /= norm;
        patch.gradient_y_[i] /= norm;
        const double gx = patch.gradient_x_[i];
        const double gy = patch.gradient_y_[i];
        patch.hessian_(0, 0) += gx * gx;
        patch.hessian_(0, 1) += gx * gy;
        patch.hessian_(1, 1) += gy * gy;
    }
    patch.hessian_(1, 0) = patch.hessian_(0, 1);
    return patch;
}

std::optional<Patch::Alignment> Patch::align(const cv::Mat& image,
                                             const Eigen::Vector2d& start,
                                             bool along_row) const {
    const double least = along_row ? hessian_(0, 0) : hessian_.determinant();
    if (least < 1e-6) return std::nullopt;
    Eigen::Matrix2d inverse = Eigen::Matrix2d::Zero();
    if (!along_row) inverse = hessian_.inverse();
    Alignment result{start, 0.0};
    std::array<float, kNumPixels> seen{};
    for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
        if (!inside(image, result.pixel, kRadius_px + 1)) return std::nullopt;
        read_square<kSide_px>(image, result.pixel, seen.data());
        float norm = 0.0F;
        if (!normalise(seen, norm)) return std::nullopt;
        float bx = 0.0F;
        float by = 0.0F;
        float correlation = 0.0F;
        for (int i = 0; i < kNumPixels; ++i) {
            const float difference = seen[i] - value_[i];
            bx += gradient_x_[i] * difference;
            by += gradient_y_[i] * difference;
            correlation += seen[i] * value_[i];
        }
        result.correlation = correlation;
        const Eigen::Vector2d step = along_row ? Eigen::Vector2d(bx / hessian_(0, 0), 0.0)
                                               : Eigen::Vector2d(inverse * Eigen::Vector2d(bx, by));
        result.pixel -= step;
        if ((result.pixel - start).norm() > kFarthest_px) return std::nullopt;
        if (step.norm() < kConverged_px) break;
    }
    return result;
}

}  // namespace divemesh::worker
