#include "worker/camera/range_correction.hpp"

#include <algorithm>
#include <cmath>

#include "worker/base/parallel.hpp"
#include "worker/camera/projection.hpp"
#include "worker/camera/rectified_lens.hpp"
#include "worker/camera/resampled_by_depth.hpp"
#include "worker/camera/virtual_camera.hpp"

namespace divemesh::camera {
namespace {

constexpr int kColumns = 33;
constexpr int kRows = 25;
constexpr int kLayers = 64;
constexpr double kMaxDisparity_px = 768.0;  // what is searched at half the size, in whole pixels
constexpr int kIterations = 8;              // each leaves about a hundredth of the error
constexpr double kMinDisparity_px = 1e-3;

// A rectified pair behind ports, with its refracted rays.
class PortedPair {
public:
    PortedPair(const types::Rig& rig, const types::RectifiedRig& rectified)
        : rectified_(rectified),
          lenses_(rectified_lenses(rig)),
          T_cam1_rectified_(rig.T_cam1_cam0() * Eigen::Isometry3d(lenses_[0].R_camera_rectified)) {}

    // Returns what an ideal pair shows of the point that this pair shows at (u, v, disparity).
    Eigen::Vector3d ideal_px(const Eigen::Vector3d& measured_px) const {
        const Eigen::Vector2d left_px = measured_px.head<2>();
        const Ray ray = left_ray(left_px);
        double ideal_px = std::max(kMinDisparity_px, measured_px.z());
        for (int i = 0; i < kIterations; ++i) {
            const double shown_px = left_px.x() - right_px(ray.at_depth(depth_m(ideal_px))).x();
            ideal_px = std::max(kMinDisparity_px, ideal_px + measured_px.z() - shown_px);
        }
        const Eigen::Vector2d at = rectified_.pixel(ray.at_depth(depth_m(ideal_px)));
        return {at.x(), at.y(), ideal_px};
    }

private:
    // In the rectified left camera.
    struct Ray {
        Eigen::Vector3d origin;
        Eigen::Vector3d direction;
        Eigen::Vector3d at_depth(double depth_m) const {
            return origin + (depth_m - origin.z()) / direction.z() * direction;
        }
    };

    double depth_m(double disparity_px) const { return rectified_.depth_m(disparity_px); }

    Ray left_ray(const Eigen::Vector2d& left_px) const {
        const RectifiedLens& left = lenses_[0];
        const base::Ray ray = sight_ray(left.camera, left.recorded_px(rectified_, left_px));
        const Eigen::Matrix3d R_rectified_camera = left.R_camera_rectified.transpose();
        return {R_rectified_camera * ray.origin, R_rectified_camera * ray.direction};
    }

    // Returns where the rectified right image shows a point of the rectified left camera.
    Eigen::Vector2d right_px(const Eigen::Vector3d& p_rectified) const {
        const RectifiedLens& right = lenses_[1];
        const Eigen::Vector3d p_cam1 = T_cam1_rectified_ * p_rectified;
        const auto recorded = project(right.camera, p_cam1);
        if (recorded) return right.rectified_px(rectified_, *recorded);
        return rectified_.pixel(right.R_camera_rectified.transpose() * p_cam1);  // as an ideal one
    }

    const types::RectifiedRig& rectified_;
    std::array<RectifiedLens, 2> lenses_;
    Eigen::Isometry3d T_cam1_rectified_;
};

types::RangeTable empty_table(const types::RectifiedRig& rectified) {
    types::RangeTable table;
    table.num_columns = kColumns;
    table.num_rows = kRows;
    table.num_layers = kLayers;
    table.column_px = (rectified.width_px - 1.0) / (kColumns - 1);
    table.row_px = (rectified.height_px - 1.0) / (kRows - 1);
    table.layer_root_px = std::sqrt(kMaxDisparity_px) / (kLayers - 1);
    table.shifts_px.resize(static_cast<std::size_t>(kLayers) * kRows * kColumns);
    return table;
}

}  // namespace

std::shared_ptr<const types::RangeTable> range_table(const types::Rig& rig,
                                                     const types::RectifiedRig& rectified,
                                                     int num_threads) {
    if (!has_port(rig)) return nullptr;
    const PortedPair pair(rig, rectified);
    auto table = std::make_shared<types::RangeTable>(empty_table(rectified));
    base::for_each_index(num_threads, kLayers, [&](std::size_t index) {
        const int layer = static_cast<int>(index);
        const double root_px = layer * table->layer_root_px;
        for (int row = 0; row < kRows; ++row)
            for (int column = 0; column < kColumns; ++column) {
                const Eigen::Vector3d measured_px(
                    column * table->column_px, row * table->row_px, root_px * root_px);
                table->node(layer, row, column) =
                    (pair.ideal_px(measured_px) - measured_px).cast<float>();
            }
    });
    return table;
}

Eigen::Vector3d at_own_range(const types::RangeTable& table, const Eigen::Vector3d& measured_px) {
    Eigen::Vector3d result = measured_px;
    result.head<2>() += table.shift_px(measured_px).head<2>();
    return result;
}

types::KeyframeImages at_own_range(const types::RangeTable& table,
                                   const types::KeyframeImages& images) {
    return resampled_by_depth(
        images, 1, [&](int, int, float x, float y, float disparity_px) -> Eigen::Vector3f {
            const Eigen::Vector3f shift = table.shift_px({x, y, disparity_px}).cast<float>();
            return {-shift.x(), -shift.y(), 0.0F};
        });
}

}  // namespace divemesh::camera
