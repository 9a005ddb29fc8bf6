#include "worker/board_calibration/calibrate_recording.hpp"

#include <fstream>

#include "schemas/enum_text.hpp"
#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "worker/base/atomic_file.hpp"
#include "worker/board_calibration/calibration_page.hpp"
#include "worker/board_calibration/pick_views.hpp"
#include "worker/camera/lens_model.hpp"
#include "worker/dive/lens_yaml.hpp"
#include "worker/dive/sensor_yaml_text.hpp"
#include "worker/recording/read_rig.hpp"
#include "worker/recording/recorded_dive.hpp"

namespace divemesh::board_calibration {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxSearchedPairs = 240;  // of a second or two each
constexpr std::size_t kMaxViews = 80;           // more add little and cost time
constexpr std::size_t kMaxTarget_bytes = 1 << 16;

boards::Board read_board(const fs::path& target) {
    std::ifstream file(target, std::ios::binary);
    if (!file || fs::is_directory(target))
        throw Error(ErrorCode::NotFound,
                    target.string() + " cannot be read: give the target file by --target");
    std::string text(kMaxTarget_bytes + 1, '\0');
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(file.gcount()));
    if (text.size() > kMaxTarget_bytes)
        throw Error(ErrorCode::BadData,
                    target.string() + " has more than 64 KiB: that is no target file of Kalibr");
    return boards::parse_board(text, target.filename().string());
}

std::string yaml_text(const types::Camera& camera, const Eigen::Isometry3d& T_body_cam) {
    dive::SensorYaml yaml;
    yaml.T_body_sensor = T_body_cam.matrix();
    dive::state_lens(camera, yaml);
    yaml.resolution = {static_cast<double>(camera.width_px), static_cast<double>(camera.height_px)};
    return dive::camera_yaml_text(yaml, {.comment = "calibrated with a board by divemesh"});
}

recording::RigFiles rig_files(const RigParameters& rig, const Eigen::Isometry3d& T_body_cam0) {
    recording::RigFiles files;
    files.cam0 = {rig.cam0(), T_body_cam0};
    files.cam1 = {rig.cam1(), T_body_cam0 * isometry_of(rig.T_cam1_cam0).inverse()};
    files.cam0_yaml = yaml_text(files.cam0.camera, files.cam0.T_body_cam);
    files.cam1_yaml = yaml_text(files.cam1.camera, files.cam1.T_body_cam);
    return files;
}

// Says so before the work is done.
void check_is_new(const fs::path& out) {
    const fs::path yaml = out / "mav0" / "cam0" / "sensor.yaml";
    if (fs::exists(yaml))
        throw Error(ErrorCode::Conflict,
                    yaml.string() + " exists: remove it, or choose another folder by --out");
}

// Adds what the recording says to what the calibration says.
void add_findings(const std::vector<Finding>& of_recording, RigVerdict& verdict) {
    verdict.findings.insert(verdict.findings.begin(), of_recording.begin(), of_recording.end());
}

}  // namespace

std::optional<types::Distortion> model_from_string(std::string_view text) {
    using Model = std::optional<types::Distortion>;
    std::vector<EnumText<Model>> words = {{std::nullopt, "auto"}};
    for (const camera::LensModel& model : camera::lens_models())
        if (model.num_coefficients > 0) words.push_back({model.distortion, model.name});
    return enum_from_text<Model>(words, text, "lens model");
}

nlohmann::json calibrate_recording(const CalibrationRequest& request,
                                   const base::ProgressCallback& progress) {
    check_is_new(request.out);
    const boards::Board board = read_board(request.target);
    const boards::BoardRecording recorded(
        recording::as_dive(request.recording, request.scratch, progress),
        request.scratch,
        progress,
        request.links);
    const auto seen = recorded.find_boards(
        board, kMaxSearchedPairs, {"find board", 0.0, 1.0, progress}, request.num_threads);
    const cv::Size left = recorded.left_size();
    const cv::Size right = recorded.right_size();
    const RigEstimate estimate = calibrate_rig(board,
                                               pick_views(board, seen, left, right, kMaxViews),
                                               left,
                                               right,
                                               request.model,
                                               {"calibrate", 0.0, 1.0, progress});
    RigVerdict verdict = judge_rig(board, estimate);
    add_findings(recorded.findings(), verdict);
    nlohmann::json document = calibration_document(estimate, verdict);
    document["num_pairs"] = recorded.num_pairs();
    document["num_pairs_with_board"] = seen.size();
    fs::create_directories(request.out);
    if (estimate.failure.empty())
        recording::write_rig(rig_files(estimate.rig, recorded.T_body_cam0()), request.out);
    const auto replace = nlohmann::json::error_handler_t::replace;
    base::write_file(request.out / "calibration.json",
                     document.dump(2, ' ', false, replace) + "\n");
    base::write_file(request.out / "report.html", calibration_page(estimate, document));
    return document;
}

}  // namespace divemesh::board_calibration
