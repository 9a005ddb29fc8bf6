#include "sensor/recording/rig_file.hpp"

#include <fstream>
#include <string>

#include "worker/camera/virtual_camera.hpp"
#include "worker/dive/calibration.hpp"
#include "worker/dive/sensor_yaml.hpp"

namespace divemesh::sensor {
namespace {

std::optional<dive::CalibratedCamera> read_camera(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::string text(static_cast<std::size_t>(dive::kMaxYamlBytes), '\0');
    stream.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(stream.gcount()));
    dive::FindingLog findings;
    const auto yaml = dive::parse_sensor_yaml(text, file.string(), findings);
    return yaml ? dive::calibrated_camera(*yaml, file.string(), findings) : std::nullopt;
}

}  // namespace

std::optional<types::Rig> read_rig(const std::filesystem::path& dive_root) {
    const auto cam0 = read_camera(dive_root / "cam0" / "sensor.yaml");
    const auto cam1 = read_camera(dive_root / "cam1" / "sensor.yaml");
    if (!cam0 || !cam1) return std::nullopt;
    types::Rig rig;
    rig.cam0 = cam0->camera;
    rig.cam1 = cam1->camera;
    rig.T_imu_cam0 = cam0->T_body_cam;
    rig.T_imu_cam1 = cam1->T_body_cam;
    // What the water is like is not known during the dive.
    constexpr double kWaterIndex = 1.34;
    camera::move_into_water(rig.cam0, rig.T_imu_cam0, kWaterIndex);
    camera::move_into_water(rig.cam1, rig.T_imu_cam1, kWaterIndex);
    if (!(rig.baseline_m() > 1e-3)) return std::nullopt;
    return rig;
}

}  // namespace divemesh::sensor
