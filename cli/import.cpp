#include <array>
#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/command.hpp"
#include "cli/exit_code.hpp"
#include "cli/findings_text.hpp"
#include "cli/follow.hpp"
#include "cli/import_kind.hpp"
#include "cli/import_stills.hpp"
#include "cli/import_video.hpp"
#include "cli/imported_text.hpp"
#include "cli/interrupt.hpp"
#include "cli/progress_bar.hpp"
#include "cli/text.hpp"
#include "schemas/json.hpp"
#include "worker/recording/import_recording.hpp"
#include "worker/recording/imu_clock.hpp"
#include "worker/recording/read_rig.hpp"
#include "worker/recording/recorded_kind.hpp"

namespace divemesh::cli {
namespace {

struct ImportArguments {
    std::vector<std::filesystem::path> recordings;
    recording::ImportOptions options;  // of recordings of all kinds
    std::shared_ptr<recording::StillsOptions> stills;
    std::shared_ptr<recording::VideoImportOptions> video;
    std::optional<double> rate_hz;  // of images or of pairs, whatever is imported
    bool is_uncalibrated = false;   // of images or of videos
    std::string unit;
    std::optional<std::array<double, 2>> size_px;  // of the images, which the recording tells too
    std::string size;
    std::vector<std::string> given;  // options of the command line, such as "--left"
};

constexpr std::array<std::pair<const char*, double>, 3> kUnits_m = {
    {{"m", 1.0}, {"cm", 1e-2}, {"mm", 1e-3}}};

// Reads the options that are words. Throws CLI::ValidationError.
void read_words(ImportArguments& arguments) {
    if (arguments.recordings.empty() && arguments.options.calibration.empty())
        throw CLI::RequiredError("recording, or --calibration alone,");
    if (!arguments.unit.empty() && arguments.options.calibration.empty())
        throw CLI::RequiredError("--calibration, whose unit --calibration-unit is,");
    for (const auto& [unit, metres] : kUnits_m)
        if (arguments.unit == unit) arguments.options.metres_per_unit = metres;
    arguments.stills->is_uncalibrated = arguments.is_uncalibrated;
    arguments.video->is_uncalibrated = arguments.is_uncalibrated;
    int width = 0;
    int height = 0;
    char rest = 0;
    if (arguments.rate_hz) {
        arguments.stills->times.rate_hz = arguments.rate_hz;
        arguments.video->rate_hz = *arguments.rate_hz;
    }
    if (arguments.size.empty()) return;
    if (std::sscanf(arguments.size.c_str(), "%6dx%6d%c", &width, &height, &rest) != 2)
        throw CLI::ValidationError("--image-size", "is not like 1920x1080");
    arguments.size_px = {static_cast<double>(width), static_cast<double>(height)};
}

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

// Makes sensor.yaml files of a calibration alone.
int write_calibration(const ImportArguments& arguments, const Context& context) {
    dive::FindingLog findings;
    recording::RigHints hints;
    if (arguments.size_px) hints.resolution = {(*arguments.size_px)[0], (*arguments.size_px)[1]};
    hints.metres_per_unit = arguments.options.metres_per_unit;
    const auto rig = recording::read_rig(arguments.options.calibration, findings, hints);
    recording::report_unapplied_shift(rig, findings);
    recording::write_rig(rig, arguments.options.out);
    if (context.json) {
        std::cout << nlohmann::json{{"findings", findings.all()}}.dump(2) << '\n';
        return kExitDone;
    }
    for (const Finding& finding : findings.all()) std::cout << finding_text(finding);
    const auto T_cam0_cam1 = rig.cam0.T_body_cam.inverse() * rig.cam1.T_body_cam;
    std::cout << arguments.options.out.string() << ": sensor.yaml of cam0, cam1"
              << (rig.imu_yaml ? ", imu0" : "") << "; baseline " << T_cam0_cam1.translation().norm()
              << " m, focal length " << rig.cam0.camera.fx_px << " px at "
              << rig.cam0.camera.width_px << " x " << rig.cam0.camera.height_px << " px\n";
    return kExitDone;
}

int import_messages(const recording::ImportOptions& options, const Context& context) {
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
        nlohmann::json json = imported_json(counts, recorded.findings());
        json["topics"] = topics_json(recorded);
        std::cout << json.dump(2) << '\n';
        return kExitDone;
    }
    std::cout << imported_text(counts, recorded.findings(), options.out);
    return kExitDone;
}

// Returns what the recordings are; nullopt for what none of the imports reads, as they say
// themselves.
std::optional<ImportKind> kind_of(const std::vector<std::filesystem::path>& recordings) {
    if (recordings.empty()) return ImportKind::CalibrationAlone;
    const std::filesystem::path& first = recordings.front();
    if (recording::is_image_folder(first)) return ImportKind::Images;
    if (std::filesystem::is_directory(first)) return ImportKind::Messages;
    if (recording::is_video_file(first)) return ImportKind::Videos;
    const auto kind = recording::recorded_kind(first).kind;
    if (kind == recording::RecordedKind::Kind::Messages) return ImportKind::Messages;
    if (kind == recording::RecordedKind::Kind::Images) return ImportKind::Images;  // an archive
    return std::nullopt;
}

int run(const ImportArguments& arguments, const Context& context) {
    recording::ImportOptions options = arguments.options;
    if (!arguments.recordings.empty()) options.recording = arguments.recordings.front();
    const auto kind = kind_of(arguments.recordings);
    if (kind) check_options_apply(arguments.given, *kind, options.recording.string());
    if (kind == ImportKind::CalibrationAlone) return write_calibration(arguments, context);
    if (kind == ImportKind::Images)
        return import_stills(arguments.recordings, options, *arguments.stills, context);
    if (kind == ImportKind::Videos || arguments.recordings.size() > 1)
        return import_video(arguments.recordings, options, *arguments.video, context);
    return import_messages(options, context);
}

// Returns the options of the command line alone: those of the environment and of the configuration
// are for every import, so they may not apply.
std::vector<std::string> given_options(const CLI::App& command) {
    std::vector<std::string> names;
    for (const CLI::Option* option : command.parse_order()) names.push_back(option->get_name());
    return names;
}

}  // namespace

void add_import(CLI::App& app, Context& context) {
    auto* command = app.add_subcommand(
        "import",
        "turn a ROS bag, an MCAP recording, videos or folders of images into a dive, or a "
        "calibration into sensor.yaml files");
    auto arguments = std::make_shared<ImportArguments>();
    recording::ImportOptions& options = arguments->options;
    // clang-format off
    command->add_option("recording", arguments->recordings, "ROS 1 bag (.bag), MCAP (.mcap), ROS 2 bag (.db3) or its folder; videos (MP4, MOV, MKV, AVI): left and right, or one of both; a folder or an archive of images, or two: left and right; none: --calibration alone writes sensor.yaml files into --out")->expected(0, 2);
    command->add_option("--out", options.out, "folder of the dive, which must not exist; without a recording it may")->required();
    command->add_option("--left", options.topics.left, "topic or folder of the left camera; default: by its name");
    command->add_option("--right", options.topics.right, "topic or folder of the right camera");
    command->add_option("--imu", options.topics.imu, "topic of the IMU, or none; default: the only one");
    auto* calibration = command->add_option("--calibration", options.calibration, "folder of a dive whose sensor.yaml files are used (cam0, cam1, imu0), or files of Kalibr, OpenCV, ROS, KWIVER, Matlab or COLMAP; after the recording; default: that of the recording");
    command->add_flag("--uncalibrated", arguments->is_uncalibrated, "the videos or images have no calibration yet: divemesh calibrate makes it from this dive")->excludes(calibration);
    command->add_option("--calibration-unit", arguments->unit, "unit of T in files of OpenCV, KWIVER and Matlab; default: m or mm by its size")->check(CLI::IsMember({"m", "cm", "mm"}));
    command->add_option("--image-size", arguments->size, "size of the images, such as 1920x1080, where neither a recording nor the calibration states it");
    command->add_option("--rate", arguments->rate_hz, "pairs a second: of images whose names count them, or those that are taken of videos (default 10)");
    // clang-format on
    arguments->stills = add_stills_options(*command);
    arguments->video = add_video_options(*command);
    command->callback([arguments, &context, command] {
        read_words(*arguments);
        arguments->given = given_options(*command);
        context.command = [arguments, &context] { return run(*arguments, context); };
    });
}

}  // namespace divemesh::cli
