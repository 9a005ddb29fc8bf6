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
};

void add_options(CLI::App& command, worker::SimulateOptions& options, Words& words) {
    // clang-format off
    command.add_option("--scene", words.scene, "tank (in air), barge, reef, bed (a plane) or transect (a reef as long as the path, straight)")->capture_default_str();
    command.add_option("--out", options.out, "folder of the dive, made when missing")->required();
    command.add_option("--length-m", options.length_m, "length of the path, of a lap with --laps")->capture_default_str();
    command.add_option("--rate", options.rate_hz, "stereo pairs per second")->capture_default_str();
    command.add_option("--seed", options.seed, "of place, rig, motion and noise")->capture_default_str();
    command.add_option("--water", words.water, "none, clear, green or turbid; else as the scene has it");
    command.add_option("--laps", options.laps, "a closed lap, swum so many times; 0: an open path")->capture_default_str();
    command.add_option("--year", options.year, "the same place so many years on (change.json)")->capture_default_str();
    command.add_option("--survey", options.survey, "2, 3, ...: another dive of that year, on another path")->capture_default_str();
    command.add_flag("--truth", options.truth, "also write depth, albedo and masks of fish and snow");
    command.add_flag("--snow,!--no-snow", options.snow, "marine snow");
    command.add_flag("--fish,!--no-fish", options.fish, "moving fish");
    command.add_flag("--caustics,!--no-caustics", options.caustics, "moving light of the waves");
    command.add_flag("--noise,!--no-noise", options.noise, "noise of pictures, IMU and AHRS");
    command.add_option("--width-px", options.width_px, "of a picture")->capture_default_str();
    command.add_option("--height-px", options.height_px, "of a picture")->capture_default_str();
    command.add_flag("--png", options.png, "pictures as PNG, not JPEG");
    command.add_option("--jpeg-quality", options.jpeg_quality, "1 to 100")->capture_default_str();
    command.add_option("--markers", options.num_markers, "AprilTags on the ground along the path, and markers.json")->capture_default_str();
    command.add_option("--marker-family", words.marker_family, "tag36h11, tag25h9 or tagStandard41h12")->capture_default_str();
    command.add_option("--marker-size-m", options.marker_size_m, "printed size of the tags")->capture_default_str();
    command.add_option("--threads", options.num_threads, "0: all cores; never changes a byte")->capture_default_str();
    // clang-format on
}

int run(worker::SimulateOptions options, const Words& words) {
    options.scene = worker::scene_kind_from_string(words.scene);
    if (!words.water.empty()) options.water = worker::water_kind_from_string(words.water);
    options.marker_family = worker::marker_family_from_string(words.marker_family);
    catch_interrupts();
    ProgressBar bar;
    worker::simulate(options, [&](const Progress& progress) {
        throw_if_interrupted();
        show_progress(bar, progress);
    });
    return kExitDone;
}

}  // namespace

void add_simulate(CLI::App& app, Context& context) {
    auto* command = app.add_subcommand("simulate", "render a dive with exact ground truth");
    auto options = std::make_shared<worker::SimulateOptions>();
    auto words = std::make_shared<Words>();
    add_options(*command, *options, *words);
    command->callback([options, words, &context] {
        context.command = [options, words] { return run(*options, *words); };
    });
}

}  // namespace divemesh::cli
