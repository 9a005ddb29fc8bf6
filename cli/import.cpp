#include <iostream>
#include <map>
#include <memory>
#include <string>

#include "cli/command.hpp"
#include "cli/exit_code.hpp"
#include "cli/findings_text.hpp"
#include "cli/follow.hpp"
#include "cli/import_video.hpp"
#include "cli/interrupt.hpp"
#include "cli/progress_bar.hpp"
#include "cli/text.hpp"
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

// What the command line states, for a recording of a robot or for videos.
struct ImportArguments {
    recording::ImportOptions recorded;
    recording::VideoImportOptions videos;
};

const std::map<std::string, recording::VideoLayout> kLayouts = {
    {"two-files", recording::VideoLayout::TwoFiles},
    {"side-by-side", recording::VideoLayout::SideBySide},
    {"over-under", recording::VideoLayout::OverUnder}};

// Imports videos, or the one recording of a robot.
int run_either(const ImportArguments& arguments, const Context& context) {
    recording::VideoImportOptions videos = arguments.videos;
    if (videos.videos.size() > 1 || recording::is_video_file(videos.videos.front())) {
        videos.out = arguments.recorded.out;
        videos.calibration = arguments.recorded.calibration;
        return run_video_import(videos, context);
    }
    recording::ImportOptions recorded = arguments.recorded;
    recorded.recording = videos.videos.front();
    return run(recorded, context);
}

}  // namespace

void add_import(CLI::App& app, Context& context) {
    auto* command =
        app.add_subcommand("import", "turn a ROS bag, an MCAP recording or videos into a dive");
    auto arguments = std::make_shared<ImportArguments>();
    auto* options = &arguments->recorded;
    auto* videos = &arguments->videos;
    // clang-format off
    command->add_option("recording", videos->videos, "ROS 1 bag (.bag) or MCAP (.mcap); videos (MP4, MOV, MKV, AVI): left and right, or one of both")->required()->expected(1, 2);
    command->add_option("--out", options->out, "folder of the dive, which must not exist")->required();
    command->add_option("--left", options->topics.left, "topic of the left camera; default: by its name");
    command->add_option("--right", options->topics.right, "topic of the right camera");
    command->add_option("--imu", options->topics.imu, "topic of the IMU, or none; default: the only one");
    command->add_option("--calibration", options->calibration, "folder of a dive whose sensor.yaml files are used (cam0, cam1, imu0); default: CameraInfo of the recording");
    command->add_option("--layout", videos->layout, "of a video that holds both cameras: side-by-side or over-under")->transform(CLI::CheckedTransformer(kLayouts));
    command->add_option("--rate", videos->rate_hz, "pairs a second that are taken of videos")->capture_default_str();
    command->add_option("--offset", videos->offset_s, "time of a moment in the left video minus its time in the right one, s; default: by sound, file times or motion");
    // clang-format on
    command->callback([arguments, &context] {
        context.command = [arguments, &context] { return run_either(*arguments, context); };
    });
}

}  // namespace divemesh::cli
