#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

#include "worker/base/observer.hpp"
#include "worker/dive/marker_family.hpp"
#include "worker/simulator/stretch.hpp"
#include "worker/types/camera.hpp"
#include "worker/types/outside_positions.hpp"

namespace divemesh::simulator {

// tank: a furnished room in air. barge: a sunken hull on sand. reef: coral heads and sand channels.
// bed: a plane, to show what a wrong calibration bends. transect: a straight path over a reef as
// long as the path; takes 7 MB of memory per metre.
enum class SceneKind { Tank, Barge, Reef, Bed, Transect };
// Visibility: clear about 15 m, green 5 to 6 m, turbid 2 to 3 m.
enum class WaterKind { None, Clear, Green, Turbid };

std::string_view to_string(SceneKind kind);
std::string_view to_string(WaterKind kind);
SceneKind scene_kind_from_string(std::string_view text);  // throws Error{InvalidArgument}
WaterKind water_kind_from_string(std::string_view text);  // throws Error{InvalidArgument}
// Returns the lens model of a name (LensModel::name). Throws Error{InvalidArgument}.
types::Distortion lens_from_string(std::string_view text);
// Returns the kind of usbl, gps-float or surface-fix. Throws Error{InvalidArgument}.
types::PositionKind position_kind_from_string(std::string_view text);

types::Port::Shape port_shape_from_string(std::string_view text);  // throws Error{InvalidArgument}

// The ports of a simulated rig, one before each camera.
struct SimulatedPorts {
    types::Port::Shape shape = types::Port::Shape::Flat;
    double distance_m = 0.025;  // flat: from the lens to the inner face
    double tilt_deg = 0.5;      // flat: of both, to the outside
    double radius_m = 0.05;     // dome: of the inner face
    double offset_m = 0.003;    // dome: of the lens, before its centre
    double thickness_m = 0.006;
    bool described = true;  // sensor.yaml states them
};

// Options of a simulated dive.
struct SimulateOptions {
    SceneKind scene = SceneKind::Barge;
    std::filesystem::path out;       // created; must not contain a dive yet
    double length_m = 6.0;           // of the path, or of one lap if `laps` > 0
    double rate_hz = 10.0;           // stereo pairs per second, from 0.25
    std::uint64_t seed = 1;          // of place, rig, motion and noise
    std::optional<WaterKind> water;  // unset: none for the tank, green elsewhere
    int laps = 0;                    // 0: an open path; N: a closed lap, swum N times
    int year = 1;                    // 2: the same place a year later (change.json), and so on
    int survey = 1;                  // 2: another dive of that year: other path, water and noise
    bool truth = false;              // also depth, albedo, masks of fish and snow (truth/)
    bool snow = true;                // snow, fish and caustics: under water only
    bool fish = true;
    bool caustics = true;
    bool noise = true;  // of images, IMU and AHRS
    int width_px = 640;
    int height_px = 480;
    bool png = false;  // else JPEG
    int jpeg_quality = 93;
    int num_markers = 0;  // AprilTags on the ground along the path, and markers.json
    dive::MarkerFamily marker_family = dive::MarkerFamily::Tag36h11;
    double marker_size_m = 0.12;  // as defined in docs/markers.md
    // Positions by another instrument (mav0/position0), with outliers; nullopt: none.
    std::optional<types::PositionKind> positions;
    bool dvl = false;             // velocities over ground (mav0/velocity0)
    bool control_points = false;  // positions of the markers (control_points.json), to 2 cm
    int num_threads = 0;          // 0: one per core

    // Faults and conditions of the dive. The defaults change nothing.
    double speed = 1.0;               // times the scene's
    double sway = 1.0;                // times a diver's; 0: an even glide
    double swing_deg_s = 0.0;         // highest rate of a swing in yaw, 20 degrees to each side
    std::vector<Stretch> pauses;      // the rig is at rest; open paths only
    std::vector<Stretch> blue_water;  // the images show only water
    double light = 1.0;               // times the usual: less light, more noise
    double turbidity = 1.0;           // times attenuation and backscatter of the water
    double texture_contrast = 1.0;    // times that of the materials; 0: one tone each
    double snow_density = 1.0;        // times that of the water
    double fish_density = 1.0;        // times one fish for every four seconds
    double stereo_offset_ms = 0.0;    // delay of the right camera that its timestamps do not show
    double calibration_error = 0.0;   // times typical: draw_calibration_error()
    double vertical_misalignment_px = 0.0;  // of rectified images; not in the calibration

    types::Distortion lens = types::Distortion::RadialTangential;  // of both cameras
    std::optional<SimulatedPorts> ports;                           // unset: none
    double salinity_psu = 35.0;                                    // of the water, of 14 degrees
};

// Renders a dive with exact ground truth into `options.out`: images, IMU, AHRS, trajectory,
// reference.ply (what cam0 saw within 4 m), scene.ply (all that was seen), measurements.json. A
// calibration with errors is written where that of a dive is; the images are of the true rig, which
// truth/ then states. The same options give the same bytes for any number of threads. Progress has
// one stage, "simulate". Throws Error{InvalidArgument} for options out of range, Error{Conflict} if
// `out` is not empty, and Error{OutOfSpace} if a file cannot be written.
void simulate(const SimulateOptions& options,
              const base::ProgressCallback& report = base::ignore_progress);

}  // namespace divemesh::simulator
