#include <iostream>
#include <memory>

#include "cli/command.hpp"
#include "cli/exit_code.hpp"
#include "cli/findings_text.hpp"
#include "cli/follow.hpp"
#include "cli/import_stills.hpp"
#include "cli/interrupt.hpp"
#include "cli/progress_bar.hpp"
#include "cli/text.hpp"
#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "worker/recording/import_recording.hpp"

namespace divemesh::cli {
namespace {

// Returns the table of what a recording holds and what it is used for.
std::string topics_text(const recording::RecordingImport& recorded) {
    std::vector<std::vector<std::string>> rows = {{"topic", "type", "messages", "used as"}};
    for (std::size_t i = 0; i < recorded.topics().size(); ++i) {
        const recording::Topic& topic = recorded.topics()[i];
        rows.push_back({topic.name,
                        topic.type,
                        std::to_string(topic.num_messages),
                        recorded.chosen().use_of(i)});
    }
    return table_text(rows);
}

nlohmann::json topics_json(const recording::RecordingImport& recorded) {
    nlohmann::json list = nlohmann::json::array();
    for (std::size_t i = 0; i < recorded.topics().size(); ++i) {
        const recording::Topic& topic = recorded.topics()[i];
        list.push_back({{"name", topic.name},
                        {"type", topic.type},
                        {"num_messages", topic.num_messages},
                        {"use", recorded.chosen().use_of(i)}});
    }
    return list;
}

int run(const recording::ImportOptions& options, const Context& context) {
    catch_interrupts();
    ProgressBar bar;
    const auto progress = [&](const Progress& state) {
        throw_if_interrupted();
        show_progress(bar, state);
    };
    recording::RecordingImport recorded(options, progress);
    if (!context.json) std::cout << topics_text(recorded) << std::flush;
    const recording::ImportCounts counts = recorded.write(progress);
    if (context.json) {
        std::cout << nlohmann::json{{"topics", topics_json(recorded)},
                                    {"findings", recorded.findings()},
                                    {"num_left", counts.num_left},
                                    {"num_right", counts.num_right},
                                    {"num_imu", counts.num_imu},
                                    {"num_pressures", counts.num_pressures}}
                         .dump(2)
                  << '\n';
        return kExitDone;
    }
    for (const Finding& finding : recorded.findings()) std::cout << finding_text(finding);
    std::cout << options.out.string() << ": " << counts.num_left << " left and " << counts.num_right
              << " right images, " << counts.num_imu << " IMU rows, " << counts.num_pressures
              << " depths\n";
    return kExitDone;
}

}  // namespace

void add_import(CLI::App& app, Context& context) {
    auto* command = app.add_subcommand(
        "import", "turn a ROS bag, an MCAP recording or folders of images into a dive");
    auto recordings = std::make_shared<std::vector<std::filesystem::path>>();
    auto options = std::make_shared<recording::ImportOptions>();
    // clang-format off
    command->add_option("recording", *recordings, "ROS 1 bag (.bag), MCAP (.mcap), ROS 2 bag (.db3) or its folder; a folder of images, or two: left and right")->required()->expected(1, 2);
    command->add_option("--out", options->out, "folder of the dive, which must not exist")->required();
    command->add_option("--left", options->topics.left, "topic or folder of the left camera; default: by its name");
    command->add_option("--right", options->topics.right, "topic or folder of the right camera");
    command->add_option("--imu", options->topics.imu, "topic of the IMU, or none; default: the only one");
    command->add_option("--calibration", options->calibration, "folder of a dive whose sensor.yaml files are used (cam0, cam1, imu0); default: that of the recording");
    // clang-format on
    const auto stills = add_stills_options(*command);
    command->callback([recordings, options, stills, &context] {
        context.command = [recordings, options, stills, &context] {
            if (recording::is_image_folder(recordings->front()))
                return import_stills(*recordings, *options, *stills, context);
            if (recordings->size() > 1)
                throw Error(ErrorCode::InvalidArgument,
                            recordings->front().string() +
                                " is not a folder: two recordings have to be the folders of the "
                                "left and of the right camera");
            options->recording = recordings->front();
            return run(*options, context);
        };
    });
}

}  // namespace divemesh::cli
