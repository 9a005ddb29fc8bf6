#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "worker/dive/sensor_yaml.hpp"
#include "worker/types/camera.hpp"

namespace divemesh::dive {

// A camera and its pose on the body: that of its lens, also behind a port.
struct CalibratedCamera {
    types::Camera camera;
    Eigen::Isometry3d T_body_cam = Eigen::Isometry3d::Identity();
};

// Returns the camera that sensor.yaml describes; nullopt with errors that give the reason if it is
// not valid. A doubtful calibration is a warning.
std::optional<CalibratedCamera> calibrated_camera(const SensorYaml& yaml,
                                                  const std::string& file,
                                                  FindingLog& findings);

// Returns T_BS as a rigid motion with an exactly orthonormal rotation; the identity if it is
// missing; nullopt with an error if it is not a rigid motion.
std::optional<Eigen::Isometry3d> rigid_motion(const SensorYaml& yaml,
                                              const std::string& file,
                                              FindingLog& findings);

// Returns the IMU noise that sensor.yaml states. Missing or invalid values are replaced by those of
// a small MEMS, with a finding.
types::ImuNoise imu_noise(const SensorYaml& yaml, const std::string& file, FindingLog& findings);

// Checks the poses of the two cameras relative to each other and to the body: baseline, left and
// right swapped, distances, and an inverted T_BS.
void check_stereo(const CalibratedCamera& cam0, const CalibratedCamera& cam1, FindingLog& findings);

}  // namespace divemesh::dive
