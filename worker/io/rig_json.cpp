#include "worker/io/rig_json.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "schemas/error.hpp"
#include "worker/camera/lens_model.hpp"
#include "worker/io/port_json.hpp"

namespace divemesh::io {
namespace {

using nlohmann::json;
using types::Distortion;

// Models of fewer have zeros behind them, as before there were models of more.
constexpr std::size_t kMinCoefficients = 4;
constexpr double kRotationTolerance = 1e-3;  // of a quaternion's norm

Distortion distortion_from(const std::string& name) {
    for (const camera::LensModel& model : camera::lens_models())
        if (model.name == name) return model.distortion;
    throw Error(ErrorCode::BadData, "distortion_model '" + name + "' is unknown");
}

json camera_json(const types::Camera& camera, const Eigen::Isometry3d& T_imu_cam) {
    const auto& k = camera.distortion_coefficients;
    const auto num_coefficients = static_cast<std::ptrdiff_t>(num_stated_coefficients(camera));
    json result = {{"image_size_px", {camera.width_px, camera.height_px}},
                   {"focal_px", {camera.fx_px, camera.fy_px}},
                   {"centre_px", {camera.cx_px, camera.cy_px}},
                   {"distortion_model", to_string(camera.distortion)},
                   {"distortion", std::vector<double>(k.begin(), k.begin() + num_coefficients)},
                   {"T_imu_cam", io::to_json(T_imu_cam)}};
    if (camera.port) result["port"] = to_json(*camera.port);
    if (camera.refractive_index != 1.0) result["refractive_index"] = camera.refractive_index;
    return result;
}

types::Camera camera_from(const json& entry) {
    types::Camera camera;
    camera.width_px = entry.at("image_size_px").at(0).get<int>();
    camera.height_px = entry.at("image_size_px").at(1).get<int>();
    camera.fx_px = entry.at("focal_px").at(0).get<double>();
    camera.fy_px = entry.at("focal_px").at(1).get<double>();
    camera.cx_px = entry.at("centre_px").at(0).get<double>();
    camera.cy_px = entry.at("centre_px").at(1).get<double>();
    camera.distortion = distortion_from(entry.at("distortion_model").get<std::string>());
    const auto coefficients = entry.at("distortion").get<std::vector<double>>();
    if (coefficients.size() > camera.distortion_coefficients.size())
        throw Error(ErrorCode::BadData, "a distortion has more coefficients than any lens model");
    std::copy(coefficients.begin(), coefficients.end(), camera.distortion_coefficients.begin());
    camera.refractive_index = entry.value("refractive_index", 1.0);
    if (entry.contains("port")) camera.port = port_from_json(entry.at("port"));
    return camera;
}

}  // namespace

std::string_view to_string(Distortion distortion) { return camera::lens_model(distortion).name; }

std::size_t num_stated_coefficients(const types::Camera& camera) {
    return std::max(kMinCoefficients, camera::lens_model(camera.distortion).num_coefficients);
}

json to_json(const Eigen::Isometry3d& T) {
    const Eigen::Vector3d p = T.translation();
    const Eigen::Quaterniond q(T.linear());
    return {{"position_m", {p.x(), p.y(), p.z()}},
            {"orientation_wxyz", {q.w(), q.x(), q.y(), q.z()}}};
}

Eigen::Isometry3d pose_from_json(const json& entry) {
    const auto position = entry.at("position_m").get<std::array<double, 3>>();
    const auto wxyz = entry.at("orientation_wxyz").get<std::array<double, 4>>();
    const Eigen::Quaterniond q(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
    if (!(std::abs(q.norm() - 1.0) < kRotationTolerance))
        throw Error(ErrorCode::BadData, "orientation_wxyz is not a unit quaternion");
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = q.normalized().toRotationMatrix();
    T.translation() = Eigen::Vector3d(position[0], position[1], position[2]);
    return T;
}

json to_json(const types::Rig& rig) {
    return {{"cam0", camera_json(rig.cam0, rig.T_imu_cam0)},
            {"cam1", camera_json(rig.cam1, rig.T_imu_cam1)}};
}

types::Rig rig_from_json(const json& entry) {
    types::Rig rig;
    rig.cam0 = camera_from(entry.at("cam0"));
    rig.cam1 = camera_from(entry.at("cam1"));
    rig.T_imu_cam0 = pose_from_json(entry.at("cam0").at("T_imu_cam"));
    rig.T_imu_cam1 = pose_from_json(entry.at("cam1").at("T_imu_cam"));
    return rig;
}

}  // namespace divemesh::io
