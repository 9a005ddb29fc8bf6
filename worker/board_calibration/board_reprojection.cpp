#include "worker/board_calibration/board_reprojection.hpp"

#include <array>
#include <ceres/autodiff_cost_function.h>
#include <ceres/rotation.h>
#include <utility>

#include "worker/board_calibration/rig_parameters.hpp"
#include "worker/camera/lens_table.hpp"

namespace divemesh::board_calibration {
namespace {

template <types::Distortion kDistortion>
constexpr int kLensSize =
    kPinholeSize +
    static_cast<int>(camera::kLensModels[static_cast<std::size_t>(kDistortion)].num_coefficients);

// Projects a point in front of a camera, m, as camera::project does, for automatic derivatives.
// Returns false for a point behind the camera.
template <types::Distortion kDistortion, typename T>
bool project_by_lens(const T* lens, const T* p_cam, T* pixel) {
    if (!(p_cam[2] > T(1e-6))) return false;
    const Eigen::Vector2<T> n(p_cam[0] / p_cam[2], p_cam[1] / p_cam[2]);
    const Eigen::Vector2<T> d = camera::distort<kDistortion>(lens + kPinholeSize, n);
    pixel[0] = lens[0] * d.x() + lens[2];
    pixel[1] = lens[1] * d.y() + lens[3];
    return true;
}

// Returns T p for a pose of a rotation vector and a translation.
template <typename T>
void transform(const T* pose, const T* p, T* transformed) {
    ceres::AngleAxisRotatePoint(pose, p, transformed);
    for (int i = 0; i < 3; ++i) transformed[i] += pose[3 + i];
}

template <types::Distortion kDistortion>
struct LeftReprojection {
    Eigen::Vector3d p_board;
    Eigen::Vector2d pixel;

    using Cost =
        ceres::AutoDiffCostFunction<LeftReprojection, 2, kLensSize<kDistortion>, kPoseSize>;

    template <typename T>
    bool operator()(const T* lens0, const T* T_cam0_board, T* r) const {
        const T p[3] = {T(p_board.x()), T(p_board.y()), T(p_board.z())};
        T p_cam0[3];
        transform(T_cam0_board, p, p_cam0);
        if (!project_by_lens<kDistortion>(lens0, p_cam0, r)) return false;
        r[0] -= pixel.x();
        r[1] -= pixel.y();
        return true;
    }
};

template <types::Distortion kDistortion>
struct RightReprojection {
    Eigen::Vector3d p_board;
    Eigen::Vector2d pixel;

    using Cost = ceres::
        AutoDiffCostFunction<RightReprojection, 2, kLensSize<kDistortion>, kPoseSize, kPoseSize>;

    template <typename T>
    bool operator()(const T* lens1, const T* T_cam1_cam0, const T* T_cam0_board, T* r) const {
        const T p[3] = {T(p_board.x()), T(p_board.y()), T(p_board.z())};
        T p_cam0[3];
        T p_cam1[3];
        transform(T_cam0_board, p, p_cam0);
        transform(T_cam1_cam0, p_cam0, p_cam1);
        if (!project_by_lens<kDistortion>(lens1, p_cam1, r)) return false;
        r[0] -= pixel.x();
        r[1] -= pixel.y();
        return true;
    }
};

template <typename Reprojection>
std::unique_ptr<ceres::CostFunction> create(const Eigen::Vector3d& p_board,
                                            const Eigen::Vector2d& pixel) {
    return std::make_unique<typename Reprojection::Cost>(new Reprojection{p_board, pixel});
}

// Returns create() for each lens model, in the order of types::Distortion.
template <template <types::Distortion> typename Reprojection, std::size_t... kModels>
constexpr auto by_model(std::index_sequence<kModels...>) {
    return std::array{&create<Reprojection<static_cast<types::Distortion>(kModels)>>...};
}

using EveryModel = std::make_index_sequence<camera::kLensModels.size()>;

}  // namespace

std::unique_ptr<ceres::CostFunction> left_board_reprojection(types::Distortion distortion,
                                                             const Eigen::Vector3d& p_board,
                                                             const Eigen::Vector2d& pixel) {
    static constexpr auto kCreate = by_model<LeftReprojection>(EveryModel());
    return kCreate[static_cast<std::size_t>(distortion)](p_board, pixel);
}

std::unique_ptr<ceres::CostFunction> right_board_reprojection(types::Distortion distortion,
                                                              const Eigen::Vector3d& p_board,
                                                              const Eigen::Vector2d& pixel) {
    static constexpr auto kCreate = by_model<RightReprojection>(EveryModel());
    return kCreate[static_cast<std::size_t>(distortion)](p_board, pixel);
}

}  // namespace divemesh::board_calibration
