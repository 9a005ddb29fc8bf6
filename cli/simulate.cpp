#include "worker/simulator/simulate.hpp"

#include <memory>

#include "cli/command.hpp"
#include "cli/exit_code.hpp"
#include "cli/follow.hpp"
#include "cli/interrupt.hpp"
#include "cli/progress_bar.hpp"

namespace divemesh::cli {
namespace {

struct Words {
    std::string scene = "barge";
    std::string water;
    std::string marker_family = "tag36h11";
    std::string camera_model = "radial-tangential";
    std::string pauses;
    std::string blue_water;
    std::string port;
    simulator::SimulatedPorts ports;
    bool undescribed_port = false;
    std::string positions;
};

void add_options(CLI::App& command, simulator::SimulateOptions& options, Words& words) {
    // clang-format off
    command.add_option("--scene", words.scene, "tank (in air), barge, reef, bed (a plane) or transect (a straight reef as long as the path)")->capture_default_str();
    command.add_option("--out", options.out, "folder of the dive, created if missing")->required();
    command.add_option("--length-m", options.length_m, "length of the path; with --laps, of one lap")->capture_default_str();
    command.add_option("--rate", options.rate_hz, "stereo pairs per second")->capture_default_str();
    command.add_option("--seed", options.seed, "random seed of scene, rig, motion and noise")->capture_default_str();
    command.add_option("--water", words.water, "none, clear, green or turbid; default: depends on the scene");
    command.add_option("--laps", options.laps, "times to swim a closed lap; 0: an open path")->capture_default_str();
    command.add_option("--year", options.year, "year of the dive: the same place with growth and loss (change.json)")->capture_default_str();
    command.add_option("--survey", options.survey, "2, 3, ...: another dive in the same year on another path")->capture_default_str();
    command.add_flag("--truth", options.truth, "also write depth, albedo and masks of fish and snow");
    command.add_flag("--snow,!--no-snow", options.snow, "marine snow");
    command.add_flag("--fish,!--no-fish", options.fish, "moving fish");
    command.add_flag("--caustics,!--no-caustics", options.caustics, "moving light patterns from the waves");
    command.add_flag("--noise,!--no-noise", options.noise, "noise of images, IMU and AHRS");
    command.add_option("--width-px", options.width_px, "width of the images")->capture_default_str();
    command.add_option("--height-px", options.height_px, "height of the images")->capture_default_str();
    command.add_option("--camera-model", words.camera_model, "lens of both cameras: none, radial-tangential, equidistant, rational, omnidirectional, double-sphere or extended-unified")->capture_default_str();
    command.add_flag("--png", options.png, "write images as PNG instead of JPEG");
    command.add_option("--jpeg-quality", options.jpeg_quality, "JPEG quality, 1 to 100")->capture_default_str();
    command.add_option("--markers", options.num_markers, "number of AprilTags on the ground along the path (writes markers.json)")->capture_default_str();
    command.add_option("--marker-family", words.marker_family, "tag36h11, tag25h9 or tagStandard41h12")->capture_default_str();
    command.add_option("--marker-size-m", options.marker_size_m, "printed size of the tags")->capture_default_str();
    command.add_option("--speed", options.speed, "speed of the diver as a multiple of the default")->capture_default_str();
    command.add_option("--sway", options.sway, "sway of the diver as a multiple of the default; 0: a steady glide")->capture_default_str();
    command.add_option("--swing", options.swing_deg_s, "highest rate of a swing to both sides, degrees per second")->capture_default_str();
    command.add_option("--pauses", words.pauses, "periods at rest: for each, where on the path it begins (0 to 1) and its duration in s: 0:10,0.5:5");
    command.add_option("--blue-water", words.blue_water, "periods in which only water is seen: for each, where in the dive it begins (0 to 1) and its duration in s: 0.4:6");
    command.add_option("--light", options.light, "light as a multiple of the default; less light gives more noise")->capture_default_str();
    command.add_option("--turbidity", options.turbidity, "turbidity as a multiple of that of --water")->capture_default_str();
    command.add_option("--texture-contrast", options.texture_contrast, "contrast of the materials: 1: natural, 0: each surface has one tone")->capture_default_str();
    command.add_option("--snow-density", options.snow_density, "density of the marine snow as a multiple of that of --water")->capture_default_str();
    command.add_option("--fish-density", options.fish_density, "density of the fish as a multiple of the default, one for every four seconds")->capture_default_str();
    command.add_option("--stereo-offset", options.stereo_offset_ms, "delay of the right camera in ms that its timestamps do not show")->capture_default_str();
    command.add_option("--calibration-error", options.calibration_error, "errors of the calibration, drawn by seed, as a multiple of typical ones")->capture_default_str();
    command.add_option("--vertical-misalignment", options.vertical_misalignment_px, "vertical misalignment of the pair in pixels that the calibration does not show")->capture_default_str();
    command.add_option("--port", words.port, "glass between the lenses and the water: flat or dome; default: none");
    command.add_option("--port-distance-m", words.ports.distance_m, "flat port: distance of its inner face from the lens's centre of projection")->capture_default_str();
    command.add_option("--port-tilt-deg", words.ports.tilt_deg, "flat port: tilt to the outside, in degrees")->capture_default_str();
    command.add_option("--port-radius-m", words.ports.radius_m, "dome: radius of its inner face")->capture_default_str();
    command.add_option("--port-offset-m", words.ports.offset_m, "dome: distance of the lens before its centre")->capture_default_str();
    command.add_option("--port-thickness-m", words.ports.thickness_m, "thickness of the glass")->capture_default_str();
    command.add_flag("--undescribed-port", words.undescribed_port, "do not state the port in sensor.yaml");
    command.add_option("--salinity-psu", options.salinity_psu, "salinity of the water; 0: a lake")->capture_default_str();
    command.add_option("--positions", words.positions, "positions by another instrument, with outliers: usbl, gps-float or surface-fix");
    command.add_flag("--dvl", options.dvl, "velocities over ground by a DVL");
    command.add_flag("--control-points", options.control_points, "known positions of the --markers, to 2 cm");
    command.add_option("--threads", options.num_threads, "0: all cores; the result does not depend on it")->capture_default_str();
    // clang-format on
}

int run(simulator::SimulateOptions options, const Words& words) {
    options.scene = simulator::scene_kind_from_string(words.scene);
    if (!words.water.empty()) options.water = simulator::water_kind_from_string(words.water);
    options.pauses = simulator::stretches_from_string(words.pauses);
    options.blue_water = simulator::stretches_from_string(words.blue_water);
    options.lens = simulator::lens_from_string(words.camera_model);
    options.marker_family = dive::marker_family_from_string(words.marker_family);
    if (!words.port.empty()) {
        options.ports = words.ports;
        options.ports->shape = simulator::port_shape_from_string(words.port);
        options.ports->described = !words.undescribed_port;
    }
    if (!words.positions.empty())
        options.positions = simulator::position_kind_from_string(words.positions);
    catch_interrupts();
    ProgressBar bar;
    simulator::simulate(options, [&](const Progress& progress) {
        throw_if_interrupted();
        show_progress(bar, progress);
    });
    return kExitDone;
}

}  // namespace

void add_simulate(CLI::App& app, Context& context) {
    auto* command = app.add_subcommand("simulate", "render a dive with exact ground truth");
    auto options = std::make_shared<simulator::SimulateOptions>();
    auto words = std::make_shared<Words>();
    add_options(*command, *options, *words);
    command->callback([options, words, &context] {
        context.command = [options, words] { return run(*options, *words); };
    });
}

}  // namespace divemesh::cli
