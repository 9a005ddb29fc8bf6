#include "worker/markers/triangulate_corners.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "worker/base/nearest_to_rays.hpp"

namespace divemesh::markers {
namespace {

using Vector12 = Eigen::Matrix<double, 12, 1>;

constexpr double kFar_px = 1e6;
constexpr double kMinDepth_m = 0.01;
constexpr double kMinParallax = 1e-5;  // as in nearest_to_rays()
constexpr double kReading_px = 0.1;    // best accuracy of reading a corner
constexpr int kMaxIterations = 10;
// RMS by which the last step of a solution may move the projections of a corner.
constexpr double kMaxLastStep_px = 0.1 * kReading_px;

std::vector<base::Ray> rays_of(const std::vector<CornerView>& views, std::size_t corner) {
    std::vector<base::Ray> rays;
    for (const CornerView& view : views) {
        const Eigen::Vector2d on_plane =
            (view.corners_px[corner] - view.principal_px) / view.focal_px;
        const Eigen::Isometry3d T_world_cam = view.T_cam_world.inverse();
        rays.push_back({T_world_cam.translation(),
                        T_world_cam.linear() * Eigen::Vector3d(on_plane.x(), on_plane.y(), 1.0)});
    }
    return rays;
}

// A Gauss-Newton step.
struct Step {
    Eigen::Vector3d change_m;
    double rms_px = 0.0;  // by which it moves the projections
};

std::optional<Step> gauss_newton_step(const std::vector<CornerView>& views,
                                      std::size_t corner,
                                      const Eigen::Vector3d& point) {
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    for (const CornerView& view : views) {
        const auto residual = view.residual_px(corner, point);
        if (!residual) return std::nullopt;
        const auto J = view.jacobian_px_per_m(point);
        H += J.transpose() * J;
        gradient += J.transpose() * *residual;
    }
    const Eigen::Vector3d change_m = H.ldlt().solve(gradient);
    if (!change_m.allFinite()) return std::nullopt;
    const double squares_px2 = std::max(0.0, change_m.dot(H * change_m));
    return Step{change_m, std::sqrt(squares_px2 / (2.0 * static_cast<double>(views.size())))};
}

// Returns nullopt if the iterations do not converge in front of the cameras.
std::optional<Eigen::Vector3d> triangulate_corner(const std::vector<CornerView>& views,
                                                  std::size_t corner) {
    auto point = base::nearest_to_rays(rays_of(views, corner), kMinParallax);
    if (!point) return std::nullopt;
    double last_step_px = 0.0;
    for (int i = 0; i < kMaxIterations; ++i) {
        const auto step = gauss_newton_step(views, corner, *point);
        if (!step) return std::nullopt;
        *point += step->change_m;
        last_step_px = step->rms_px;
        if (step->change_m.norm() < 1e-9) break;
    }
    return last_step_px > kMaxLastStep_px ? std::nullopt : point;
}

// The gradients of each keyframe's readings with respect to the corners, and the sums over all
// readings.
struct Pulls {
    CornerCovariance H = CornerCovariance::Zero();
    std::vector<Vector12> of_keyframe;
    double squares_px2 = 0.0;
};

Pulls pulls_of(const std::vector<CornerView>& views, const Corners& corners) {
    Pulls pulls;
    for (std::size_t i = 0; i < views.size(); ++i) {
        if (i == 0 || views[i].keyframe != views[i - 1].keyframe)
            pulls.of_keyframe.push_back(Vector12::Zero());
        for (std::size_t corner = 0; corner < dive::kNumTagCorners; ++corner) {
            const auto at = 3 * static_cast<Eigen::Index>(corner);
            const Eigen::Vector2d residual =
                views[i].residual_px(corner, corners[corner]).value_or(Eigen::Vector2d::Zero());
            const auto J = views[i].jacobian_px_per_m(corners[corner]);
            pulls.H.block<3, 3>(at, at) += J.transpose() * J;
            pulls.of_keyframe.back().segment<3>(at) += J.transpose() * residual;
            pulls.squares_px2 += residual.squaredNorm();
        }
    }
    return pulls;
}

// Returns the long-run variance with Bartlett's weights, over about the cube root of the number of
// keyframes as lags.
CornerCovariance long_run_variance(const std::vector<Vector12>& pulls) {
    CornerCovariance sum = CornerCovariance::Zero();
    const std::size_t num = pulls.size();
    const auto lags =
        std::min(num - 1, static_cast<std::size_t>(std::ceil(std::cbrt(static_cast<double>(num)))));
    for (std::size_t i = 0; i < num; ++i) {
        sum += pulls[i] * pulls[i].transpose();
        for (std::size_t lag = 1; lag <= lags && i + lag < num; ++lag) {
            const double weight = 1.0 - static_cast<double>(lag) / static_cast<double>(lags + 1);
            const CornerCovariance product = pulls[i] * pulls[i + lag].transpose();
            sum += weight * (product + product.transpose());
        }
    }
    return sum * (static_cast<double>(num) / static_cast<double>(num - 1));
}

}  // namespace

std::optional<Eigen::Vector2d> CornerView::residual_px(std::size_t corner,
                                                       const Eigen::Vector3d& p_world) const {
    const Eigen::Vector3d p_cam = T_cam_world * p_world;
    if (!(p_cam.z() > kMinDepth_m)) return std::nullopt;
    return corners_px[corner] - (focal_px / p_cam.z() * p_cam.head<2>() + principal_px);
}

Eigen::Matrix<double, 2, 3> CornerView::jacobian_px_per_m(const Eigen::Vector3d& p_world) const {
    const Eigen::Vector3d p_cam = T_cam_world * p_world;
    Eigen::Matrix<double, 2, 3> J_cam;
    J_cam << 1.0, 0.0, -p_cam.x() / p_cam.z(), 0.0, 1.0, -p_cam.y() / p_cam.z();
    return focal_px / p_cam.z() * J_cam * T_cam_world.linear();
}

double CornerView::rms_px(const Corners& corners_world) const {
    double squares = 0.0;
    for (std::size_t corner = 0; corner < dive::kNumTagCorners; ++corner) {
        const auto residual = residual_px(corner, corners_world[corner]);
        if (!residual) return kFar_px;
        squares += residual->squaredNorm();
    }
    return std::sqrt(squares / (2.0 * dive::kNumTagCorners));
}

std::optional<Corners> triangulate_corners(const std::vector<CornerView>& views) {
    Corners corners;
    for (std::size_t corner = 0; corner < dive::kNumTagCorners; ++corner) {
        const auto point = triangulate_corner(views, corner);
        if (!point) return std::nullopt;
        corners[corner] = *point;
    }
    return corners;
}

CornerFit corner_covariance(const std::vector<CornerView>& views, const Corners& corners_world) {
    const Pulls pulls = pulls_of(views, corners_world);
    const auto num_readings = 2.0 * dive::kNumTagCorners * static_cast<double>(views.size());
    CornerFit fit;
    fit.rms_px = std::sqrt(pulls.squares_px2 / std::max(1.0, num_readings - 12.0));
    const double reading_px = std::max(kReading_px, fit.rms_px);
    const CornerCovariance inverse = pulls.H.ldlt().solve(CornerCovariance::Identity());
    fit.covariance_m2 = reading_px * reading_px * inverse;
    if (pulls.of_keyframe.size() > 1)
        fit.covariance_m2 += inverse * long_run_variance(pulls.of_keyframe) * inverse;
    return fit;
}

}  // namespace divemesh::markers
