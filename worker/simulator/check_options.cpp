#include "worker/simulator/check_options.hpp"

#include <string>

#include "schemas/error.hpp"
#include "worker/simulator/scene.hpp"

namespace divemesh::simulator {
namespace {

namespace fs = std::filesystem;

void check_range(const std::string& name, double value, double low, double high) {
    if (value >= low && value <= high) return;
    throw Error(ErrorCode::InvalidArgument,
                name + " is " + std::to_string(value) + ": choose " + std::to_string(low) + " to " +
                    std::to_string(high));
}

void check_dive(const SimulateOptions& options) {
    check_range("length_m",
                options.length_m,
                0.1,
                options.scene == SceneKind::Transect ? kMaxTransectLength_m : 1000.0);
    check_range("rate_hz", options.rate_hz, 0.25, 100.0);
    check_range("laps", options.laps, 0, 1000);
    check_range("year", options.year, 1, 10);
    check_range("survey", options.survey, 1, 1000);
    check_range("speed", options.speed, 0.05, 20.0);
    check_range("sway", options.sway, 0.0, 5.0);
    check_range("swing_deg_s", options.swing_deg_s, 0.0, 360.0);
    if (options.laps > 0 && !options.pauses.empty())
        throw Error(ErrorCode::InvalidArgument,
                    "a closed lap has no pauses: leave out --laps or --pauses");
}

void check_images(const SimulateOptions& options) {
    check_range("width_px", options.width_px, 32, 4096);
    check_range("height_px", options.height_px, 32, 4096);
    check_range("jpeg_quality", options.jpeg_quality, 10, 100);
    check_range("light", options.light, 0.0, 100.0);
    check_range("turbidity", options.turbidity, 0.0, 100.0);
    check_range("texture_contrast", options.texture_contrast, 0.0, 1.0);
    check_range("snow_density", options.snow_density, 0.0, 100.0);
    check_range("fish_density", options.fish_density, 0.01, 1000.0);
    check_range("markers", options.num_markers, 0, dive::num_ids(options.marker_family));
    if (options.control_points && options.num_markers == 0)
        throw Error(ErrorCode::InvalidArgument,
                    "control points are markers whose position is known: add --markers");
    check_range("marker_size_m", options.marker_size_m, 0.02, 1.0);
}

void check_calibration(const SimulateOptions& options) {
    check_range("stereo_offset_ms", options.stereo_offset_ms, -1000.0, 1000.0);
    check_range("calibration_error", options.calibration_error, 0.0, 20.0);
    check_range("vertical_misalignment_px", options.vertical_misalignment_px, -100.0, 100.0);
}

void check_ports(const SimulateOptions& options) {
    check_range("salinity_psu", options.salinity_psu, 0.0, 45.0);
    if (!options.ports) return;
    if (options.water.value_or(WaterKind::Green) == WaterKind::None ||
        (!options.water && options.scene == SceneKind::Tank))
        throw Error(ErrorCode::InvalidArgument,
                    "a port has water before it, and the scene is in air: choose --water clear, "
                    "green or turbid");
    const SimulatedPorts& ports = *options.ports;
    check_range("port_distance_m", ports.distance_m, 0.0, 0.2);
    check_range("port_tilt_deg", ports.tilt_deg, -10.0, 10.0);
    check_range("port_radius_m", ports.radius_m, 0.02, 0.5);
    check_range("port_offset_m", ports.offset_m, -0.5 * ports.radius_m, 0.5 * ports.radius_m);
    check_range("port_thickness_m", ports.thickness_m, 0.0, 0.05);
}

void check_folder(const fs::path& out) {
    if (out.empty())
        throw Error(ErrorCode::InvalidArgument, "there is no folder for the dive: give one");
    std::error_code failure;
    if (fs::exists(out, failure) &&
        (!fs::is_directory(out, failure) || !fs::is_empty(out, failure)))
        throw Error(ErrorCode::Conflict,
                    out.string() + " exists and is not an empty folder: choose another");
}

}  // namespace

void check_options(const SimulateOptions& options) {
    check_dive(options);
    check_images(options);
    check_calibration(options);
    check_ports(options);
    check_range("num_threads", options.num_threads, 0, 1024);
    check_folder(options.out);
}

}  // namespace divemesh::simulator
