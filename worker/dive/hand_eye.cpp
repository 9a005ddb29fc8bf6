#include "worker/dive/hand_eye.hpp"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>

#include "worker/base/angle.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/base/text.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::dive {
namespace {

constexpr std::size_t kMinPairs = 6;
constexpr double kMinMotion = 0.02;  // rad/s; below this noise dominates
constexpr double kFits = 0.5;
// A wrong clock or a mirrored axis is fitted half-way by some rotation; a wrong T_BS fits as well
// as a right one.
constexpr double kFitsWell = 0.2;
constexpr double kMaxAngle_deg = 20.0;
constexpr double kClearlyWorse = 2.0;  // times the residual

// Returns the median distance from the median.
double spread(const std::vector<Eigen::Vector3d>& vectors) {
    Eigen::Vector3d centre;
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<double> values;
        values.reserve(vectors.size());
        for (const auto& v : vectors) values.push_back(v[axis]);
        centre[axis] = stats::upper_median(std::move(values));
    }
    std::vector<double> distances;
    distances.reserve(vectors.size());
    for (const auto& v : vectors) distances.push_back((v - centre).norm());
    return stats::upper_median(std::move(distances));
}

double residual(const std::vector<RotationPair>& pairs, const Eigen::Matrix3d& R_imu_cam0) {
    std::vector<Eigen::Vector3d> differences;
    differences.reserve(pairs.size());
    for (const RotationPair& pair : pairs)
        differences.push_back(pair.vision_cam0 - R_imu_cam0.transpose() * pair.gyro_imu);
    return spread(differences);
}

// Returns the SVD of the least squares over the centred rates.
Eigen::JacobiSVD<Eigen::Matrix3d> correlate(const std::vector<RotationPair>& pairs) {
    Eigen::Vector3d mean_gyro = Eigen::Vector3d::Zero();
    Eigen::Vector3d mean_vision = Eigen::Vector3d::Zero();
    for (const RotationPair& pair : pairs) {
        mean_gyro += pair.gyro_imu / static_cast<double>(pairs.size());
        mean_vision += pair.vision_cam0 / static_cast<double>(pairs.size());
    }
    Eigen::Matrix3d correlation = Eigen::Matrix3d::Zero();
    for (const RotationPair& pair : pairs)
        correlation += (pair.gyro_imu - mean_gyro) * (pair.vision_cam0 - mean_vision).transpose();
    return Eigen::JacobiSVD<Eigen::Matrix3d>(correlation,
                                             Eigen::ComputeFullU | Eigen::ComputeFullV);
}

}  // namespace

HandEye compare_rotations(const std::vector<RotationPair>& pairs,
                          const Eigen::Matrix3d& R_imu_cam0) {
    HandEye result;
    std::vector<Eigen::Vector3d> gyro;
    std::vector<Eigen::Vector3d> vision;
    for (const RotationPair& pair : pairs) {
        gyro.push_back(pair.gyro_imu);
        vision.push_back(pair.vision_cam0);
    }
    result.motion = spread(vision);
    const double motion = std::max(result.motion, 1e-9);
    result.scale = spread(gyro) / motion;
    result.given_residual = residual(pairs, R_imu_cam0) / motion;
    result.inverse_residual = residual(pairs, R_imu_cam0.transpose()) / motion;
    const auto svd = correlate(pairs);
    const double sign = svd.matrixU().determinant() * svd.matrixV().determinant() < 0 ? -1.0 : 1.0;
    const Eigen::Matrix3d R_best =
        svd.matrixU() * Eigen::Vector3d(1.0, 1.0, sign).asDiagonal() * svd.matrixV().transpose();
    result.best_residual = residual(pairs, R_best) / motion;
    result.best_angle_deg = base::angle_rad(R_best.transpose() * R_imu_cam0) * base::kDegPerRad;
    result.best_is_determined = svd.singularValues()[1] > 0.1 * svd.singularValues()[0];
    return result;
}

void report_hand_eye(const std::vector<RotationPair>& pairs,
                     const Eigen::Matrix3d& R_imu_cam0,
                     FindingLog& findings) {
    if (pairs.size() < kMinPairs) return;
    const HandEye result = compare_rotations(pairs, R_imu_cam0);
    if (result.motion < kMinMotion) return;
    if (result.scale > 20.0)
        return findings.error("imu_units",
                              "mav0/imu0/data.csv",
                              "the gyroscope shows rotations " + base::fixed(result.scale, 0) +
                                  " times as fast as the images do; this looks like degrees/s",
                              "Write rates in rad/s.");
    if (result.given_residual < kFits && result.best_angle_deg < kMaxAngle_deg) return;
    const std::string seen =
        "the rotations of the gyroscope do not match those of the images (mismatch " +
        base::fixed(100.0 * result.given_residual, 0) + " %";
    if (result.inverse_residual < kFits && result.inverse_residual < 0.5 * result.given_residual)
        return findings.error(
            "extrinsics_inverted",
            "mav0/cam0/sensor.yaml",
            "T_BS looks inverted: " + seen + ", " +
                base::fixed(100.0 * result.inverse_residual, 0) + " % with the inverse)",
            "Write the inverse of what is there: T_BS maps the sensor's coordinates to the body's "
            "(Kalibr's T_cam_imu is the inverse of T_BS).");
    // A stated rotation that fits as well as the best one is not refuted by being another: few of
    // the motions, or a wrong one among them, may decide what the best one is.
    const bool is_refuted = result.given_residual > kFitsWell &&
                            result.given_residual > kClearlyWorse * result.best_residual;
    if (is_refuted && result.best_is_determined && result.best_residual < kFitsWell &&
        result.best_angle_deg > kMaxAngle_deg)
        return findings.error("extrinsics_rotation",
                              "mav0/cam0/sensor.yaml",
                              "T_BS of the cameras is rotated by about " +
                                  base::fixed(result.best_angle_deg, 0) +
                                  " degrees relative to the IMU: " + seen + ")",
                              "Calibrate cameras and IMU together, and check the axes of the IMU.");
    const bool is_doubtful = result.given_residual > kFitsWell && result.best_is_determined &&
                             result.best_angle_deg > kMaxAngle_deg;
    if (result.given_residual < kFits && !is_doubtful) return;
    findings.warning("gyro_vision_mismatch",
                     "mav0/imu0/data.csv",
                     seen + ")",
                     "Check the time offset between cameras and IMU, and T_BS.");
}

}  // namespace divemesh::dive
