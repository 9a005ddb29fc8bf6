#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "worker/dive/sensor_yaml.hpp"
#include "worker/types/camera.hpp"

namespace divemesh::dive {

struct CalibratedCamera {
    types::Camera camera;
    Eigen::Isometry3d T_body_cam = Eigen::Isometry3d::Identity();
};

// What sensor.yaml says of a camera, when it can be one. Otherwise nothing, and errors that say
// why; a doubtful calibration is a warning.
std::optional<CalibratedCamera> calibrated_camera(const SensorYaml& yaml,
                                                  const std::string& file,
                                                  FindingLog& findings);

// T_BS as a rigid motion, its rotation made exactly orthonormal; the identity when it is not
// written. Nothing, and an error, when it is no rigid motion.
std::optional<Eigen::Isometry3d> rigid_motion(const SensorYaml& yaml,
                                              const std::string& file,
                                              FindingLog& findings);

types::ImuNoise imu_noise(const SensorYaml& yaml, const std::string& file, FindingLog& findings);

// How the two cameras stand to each other and to the body: baseline, sides, distances, and T_BS
// written the wrong way round.
void check_stereo(const CalibratedCamera& cam0, const CalibratedCamera& cam1, FindingLog& findings);

}  // namespace divemesh::dive
