#include <iostream>
#include <memory>
#include <string>

#include "cli/command.hpp"
#include "cli/exit_code.hpp"
#include "cli/findings_text.hpp"
#include "cli/follow.hpp"
#include "cli/interrupt.hpp"
#include "cli/progress_bar.hpp"
#include "cli/scratch.hpp"
#include "schemas/json.hpp"
#include "worker/board_calibration/calibrate_recording.hpp"

namespace divemesh::cli {
namespace {

struct CalibrateArguments {
    board_calibration::CalibrationRequest request;
    std::string model = "auto";
};

int calibrate(const CalibrateArguments& arguments, const Context& context) {
    catch_interrupts();
    const ScratchFolder scratch(std::filesystem::temp_directory_path());
    board_calibration::CalibrationRequest request = arguments.request;
    request.scratch = scratch.path();
    request.links = Links::Follow;
    request.model = board_calibration::model_from_string(arguments.model);
    nlohmann::json document;
    {
        ProgressBar bar;
        document = board_calibration::calibrate_recording(request, [&](const Progress& state) {
            throw_if_interrupted();
            show_progress(bar, state);
        });
    }
    if (context.json) {
        std::cout << document.dump(2) << '\n';
    } else {
        for (const auto& finding : document.at("findings").get<std::vector<Finding>>())
            std::cout << finding_text(finding);
        std::cout << "verdict: " << document.at("verdict").get<std::string>() << '\n'
                  << (request.out / "report.html").string() << '\n';
    }
    return document.at("usable").get<bool>() ? kExitDone : kExitFailed;
}

}  // namespace

void add_calibrate(CLI::App& app, Context& context) {
    auto* command =
        app.add_subcommand("calibrate", "calibrate a stereo rig by a board that it recorded");
    auto arguments = std::make_shared<CalibrateArguments>();
    board_calibration::CalibrationRequest& request = arguments->request;
    // clang-format off
    command->add_option("recording", request.recording, "dive (folder or archive; sensor.yaml may be missing), ROS bag or MCAP in which the board is held before both cameras; videos and folders of images become a dive by divemesh import --uncalibrated")->required();
    command->add_option("--target", request.target, "target file of Kalibr: a checkerboard or an aprilgrid")->required();
    command->add_option("--out", request.out, "folder for calibration.json, report.html and the sensor.yaml files")->required();
    command->add_option("--model", arguments->model, "lens model: radial-tangential, equidistant, rational, omnidirectional, double-sphere or extended-unified; auto: whichever of the first two leaves smaller errors")->capture_default_str();
    command->add_option("--threads", request.num_threads, "0: all cores; never changes the result")->check(CLI::Range(0, 1024));
    // clang-format on
    command->callback([arguments, &context] {
        context.command = [arguments, &context] { return calibrate(*arguments, context); };
    });
}

}  // namespace divemesh::cli
