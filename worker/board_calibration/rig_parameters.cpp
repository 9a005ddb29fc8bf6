#include "worker/board_calibration/rig_parameters.hpp"

#include <algorithm>
#include <tuple>

#include "worker/base/rotation_vector.hpp"
#include "worker/camera/lens_model.hpp"

namespace divemesh::board_calibration {
namespace {

static_assert(kMaxLensSize == kPinholeSize + std::tuple_size_v<types::LensCoefficients>);

void add_names(const std::string& camera,
               types::Distortion distortion,
               std::vector<std::string>& names) {
    for (const char* name : {"fx_px", "fy_px", "cx_px", "cy_px"}) names.push_back(camera + name);
    const camera::LensModel& model = camera::lens_model(distortion);
    for (const camera::LeadingCoefficient& coefficient : model.leading)
        names.push_back(camera + std::string(coefficient.name));
    for (std::size_t i = model.leading.size(); i < model.num_coefficients; ++i)
        names.push_back(camera + "distortion_" + std::to_string(i - model.leading.size()));
}

}  // namespace

int LensKind::num_values() const {
    return kPinholeSize + static_cast<int>(camera::lens_model(distortion).num_coefficients);
}

types::Camera camera_of(const LensKind& kind, const LensValues& values) {
    types::Camera camera;
    camera.width_px = kind.width_px;
    camera.height_px = kind.height_px;
    camera.distortion = kind.distortion;
    camera.fx_px = values[0];
    camera.fy_px = values[1];
    camera.cx_px = values[2];
    camera.cy_px = values[3];
    std::copy(values.begin() + kPinholeSize, values.end(), camera.distortion_coefficients.begin());
    return camera;
}

Eigen::Isometry3d isometry_of(const PoseValues& values) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = base::rotation_from_vector({values[0], values[1], values[2]}).toRotationMatrix();
    T.translation() = Eigen::Vector3d(values[3], values[4], values[5]);
    return T;
}

PoseValues values_of(const Eigen::Isometry3d& T) {
    const Eigen::Vector3d w = base::vector_from_rotation(Eigen::Quaterniond(T.linear()));
    const Eigen::Vector3d t = T.translation();
    return {w.x(), w.y(), w.z(), t.x(), t.y(), t.z()};
}

RigVector RigParameters::vector() const {
    RigVector all(size());
    auto next = std::copy_n(lens0.begin(), kind0.num_values(), all.begin());
    next = std::copy_n(lens1.begin(), kind1.num_values(), next);
    std::copy(T_cam1_cam0.begin(), T_cam1_cam0.end(), next);
    return all;
}

std::vector<std::string> RigParameters::names() const {
    std::vector<std::string> all;
    add_names("cam0_", kind0.distortion, all);
    add_names("cam1_", kind1.distortion, all);
    for (const char* name :
         {"rotation_x_rad", "rotation_y_rad", "rotation_z_rad", "x_m", "y_m", "z_m"})
        all.push_back(std::string("T_cam1_cam0_") + name);
    return all;
}

RigParameters RigParameters::changed_by(const RigVector& change) const {
    const RigVector all = vector() + change;
    const auto of_lens1 = all.begin() + kind0.num_values();
    RigParameters changed = *this;
    std::copy(all.begin(), of_lens1, changed.lens0.begin());
    std::copy_n(of_lens1, kind1.num_values(), changed.lens1.begin());
    std::copy_n(of_lens1 + kind1.num_values(), kPoseSize, changed.T_cam1_cam0.begin());
    return changed;
}

}  // namespace divemesh::board_calibration
