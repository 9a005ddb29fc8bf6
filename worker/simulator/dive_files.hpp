#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "worker/dive/marker_plan.hpp"
#include "worker/simulator/inertial_sensors.hpp"
#include "worker/simulator/scene.hpp"
#include "worker/simulator/simulate.hpp"
#include "worker/simulator/surface_change.hpp"
#include "worker/types/geographic_position.hpp"
#include "worker/types/outside_positions.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/rig.hpp"

// Writers of a dive's files in EuRoC's formats. All throw as AtomicFile does.
namespace divemesh::simulator {

struct ImageName {
    std::int64_t timestamp_ns = 0;
    std::string file;
};

void write_camera_yaml(const std::filesystem::path& folder,
                       const types::Camera& camera,
                       const Eigen::Isometry3d& T_imu_cam,
                       double rate_hz);
void write_camera_files(const std::filesystem::path& folder,
                        const types::Camera& camera,
                        const Eigen::Isometry3d& T_imu_cam,
                        double rate_hz,
                        const std::vector<ImageName>& images);
void write_imu_files(const std::filesystem::path& folder,
                     const types::ImuNoise& noise,
                     const std::vector<ImuRecord>& records);
void write_ground_truth_files(const std::filesystem::path& folder,
                              const std::vector<ImuRecord>& records);
void write_ahrs_files(const std::filesystem::path& folder,
                      const std::vector<types::OrientationSample>& samples);
void write_pressure_file(const std::filesystem::path& folder,
                         const std::vector<types::PressureSample>& samples);
// Writes the files of what other instruments told of the place: mav0/position0, mav0/velocity0,
// control_points.json, as far as there is any. `dive` is the folder of the dive.
void write_outside_files(const std::filesystem::path& dive, const types::OutsidePositions& outside);
// Writes where the world of the ground truth lies.
void write_place_on_earth(const std::filesystem::path& file,
                          const types::GeographicPosition& position);
void write_dive_info(const std::filesystem::path& file,
                     const SimulateOptions& options,
                     WaterKind water);
void write_measurements(const std::filesystem::path& file,
                        const std::vector<SceneDistance>& distances);
void write_markers(const std::filesystem::path& file, const dive::MarkerPlan& plan);
void write_changes(const std::filesystem::path& file,
                   int year,
                   const std::vector<SceneChange>& changes,
                   const std::vector<SurfaceChange>& surface);

}  // namespace divemesh::simulator
