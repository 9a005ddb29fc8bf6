#include "worker/recording/calibration_parts.hpp"

#include <algorithm>
#include <iterator>

#include "schemas/error.hpp"
#include "worker/base/rotation_vector.hpp"

namespace divemesh::recording {
namespace {

// Values beyond these are no poses, and would overflow in what is computed of them.
constexpr double kMaxRotationEntry = 10.0;
constexpr double kMaxTranslation_m = 1e6;

[[noreturn]] void fail(const std::string& what) { throw Error(ErrorCode::BadData, what); }

template <typename Part>
void take(std::optional<Part>& part,
          std::optional<Part>& target,
          const char* what,
          const std::filesystem::path& file) {
    if (!part) return;
    if (target)
        fail(file.string() + " states " + what +
             ", as a file before it does: give one calibration alone");
    target = std::move(part);
}

}  // namespace

void add_parts(CalibrationParts parts, const std::filesystem::path& file, CalibrationParts& all) {
    take(parts.left, all.left, "the left camera", file);
    take(parts.right, all.right, "the right camera", file);
    take(parts.T_cam1_cam0, all.T_cam1_cam0, "where the cameras are", file);
    take(parts.imu, all.imu, "the noise of the IMU", file);
    take(parts.imu_shift, all.imu_shift, "the clock of the IMU", file);
    std::move(parts.unsided.begin(), parts.unsided.end(), std::back_inserter(all.unsided));
    std::move(parts.infos.begin(), parts.infos.end(), std::back_inserter(all.infos));
}

Eigen::Matrix4d transform_of(const std::vector<double>& rotation,
                             const std::vector<double>& translation,
                             const std::string& file) {
    if ((rotation.size() != 9 && rotation.size() != 3) || translation.size() != 3)
        fail(file + " has " + std::to_string(rotation.size()) + " numbers of a rotation and " +
             std::to_string(translation.size()) +
             " of a translation: R has to have 9 and T 3 numbers");
    Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
    if (rotation.size() == 9)
        T.topLeftCorner<3, 3>() =
            Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rotation.data());
    else
        T.topLeftCorner<3, 3>() =
            base::rotation_from_vector(Eigen::Map<const Eigen::Vector3d>(rotation.data()))
                .toRotationMatrix();
    T.topRightCorner<3, 1>() = Eigen::Map<const Eigen::Vector3d>(translation.data());
    return T;
}

Eigen::Isometry3d rigid_transform(const Eigen::Matrix4d& T, const std::string& name) {
    dive::SensorYaml yaml;
    yaml.T_body_sensor = T;
    dive::FindingLog findings;
    const bool is_sane = T.allFinite() &&
                         T.topLeftCorner<3, 3>().cwiseAbs().maxCoeff() < kMaxRotationEntry &&
                         T.topRightCorner<3, 1>().cwiseAbs().maxCoeff() < kMaxTranslation_m;
    const auto motion = is_sane ? dive::rigid_motion(yaml, name, findings) : std::nullopt;
    if (!motion)
        fail(name + " is not a rotation and a translation in m: check the calibration's file");
    return *motion;
}

}  // namespace divemesh::recording
