#include "tests/fuzz/input.hpp"
#include "worker/dive/calibration.hpp"

// sensor.yaml of a camera and of an IMU, up to what the reconstruction is told.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    divemesh::dive::FindingLog findings;
    const std::string file = "sensor.yaml";
    const auto yaml =
        divemesh::dive::parse_sensor_yaml(divemesh::fuzz::Input(data, size).rest(), file, findings);
    if (!yaml) return 0;
    divemesh::dive::rigid_motion(*yaml, file, findings);
    divemesh::dive::imu_noise(*yaml, file, findings);
    const auto camera = divemesh::dive::calibrated_camera(*yaml, file, findings);
    if (!camera) return 0;
    divemesh::dive::CalibratedCamera beside = *camera;
    beside.T_body_cam.translation().x() += 0.1;
    divemesh::dive::check_stereo(*camera, beside, findings);
    return 0;
}
