#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "worker/dive/sensor_yaml.hpp"
#include "worker/recording/rig_files.hpp"

namespace divemesh::recording {

// Tells what is known of the images that a calibration is for.
struct RigHints {
    Rectification rectification = Rectification::Raw;
    std::vector<double> resolution;  // width and height, px; {}: not known
    std::string left_topic;          // of the images, by which Kalibr names its cameras; "": none
    std::string right_topic;
    std::optional<double> metres_per_unit;  // of translations whose unit the format leaves open
};

// What files of other programs state of a rig. T_body_sensor of a camera is its pose on the IMU.
struct CalibrationParts {
    std::optional<dive::SensorYaml> left;
    std::optional<dive::SensorYaml> right;
    std::vector<dive::SensorYaml> unsided;  // cameras of which the order of files tells the side
    std::optional<Eigen::Matrix4d> T_cam1_cam0;
    std::optional<dive::SensorYaml> imu;
    std::optional<ImuShift> imu_shift;
    std::vector<CameraInfo> infos;  // of ROS, in the order of files
};

// Adds what a further file states. Throws Error{BadData} if both state the same.
void add_parts(CalibrationParts parts, const std::filesystem::path& file, CalibrationParts& all);

// Returns [R t; 0 1] of nine numbers by rows, or the three of a rotation vector, and of three.
// Throws Error{BadData}, which names the file, if there are others.
Eigen::Matrix4d transform_of(const std::vector<double>& rotation,
                             const std::vector<double>& translation,
                             const std::string& file);

// Returns a rigid motion with an exactly orthonormal rotation. Throws Error{BadData}, which says
// that `name` is none.
Eigen::Isometry3d rigid_transform(const Eigen::Matrix4d& T, const std::string& name);

}  // namespace divemesh::recording
