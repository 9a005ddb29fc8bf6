#include "worker/recording/read_rig.hpp"

#include <yaml-cpp/yaml.h>

#include "schemas/error.hpp"
#include "worker/base/atomic_file.hpp"
#include "worker/dive/calibration_format.hpp"
#include "worker/dive/entry_name.hpp"
#include "worker/dive/yaml_document.hpp"
#include "worker/recording/assemble_rig.hpp"
#include "worker/recording/camera_info_yaml.hpp"
#include "worker/recording/colmap_cameras.hpp"
#include "worker/recording/input_file.hpp"
#include "worker/recording/kalibr_calibration.hpp"
#include "worker/recording/kwiver_calibration.hpp"
#include "worker/recording/matlab_calibration.hpp"
#include "worker/recording/npz_file.hpp"
#include "worker/recording/opencv_calibration.hpp"
#include "worker/recording/opencv_xml.hpp"

namespace divemesh::recording {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxNodes = 100'000;  // OpenCV's files can hold every corner of every image
constexpr std::size_t kMaxFiles = 8;
constexpr const char* kFormats =
    "give the folder of a dive with sensor.yaml files, camchain.yaml and imu.yaml of Kalibr, "
    "intrinsics.yml and extrinsics.yml of OpenCV, camera_info of both cameras, calibration.json "
    "or .npz of KWIVER, .mat of Matlab, or cameras.txt of COLMAP (after the recording on the "
    "command line)";

[[noreturn]] void fail(const std::string& what) { throw Error(ErrorCode::BadData, what); }

std::string text_of(const fs::path& file) {
    const InputFile input(file);
    if (input.size_bytes() > dive::kMaxYamlBytes)
        fail(file.string() + " is too large for a calibration: " + kFormats);
    return input.read(0, dive::kMaxYamlBytes);
}

YAML::Node parse(std::string_view text) {
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // the mark of UTF-8
    const std::size_t begin = text.find_first_not_of(" \t\r\n");
    const bool is_xml = begin != std::string_view::npos && text[begin] == '<';
    return is_xml ? parse_opencv_xml(text) : dive::load_yaml(text, kMaxNodes);
}

// Reads a file that no key names: noise of an IMU, or numbers by OpenCV's names.
CalibrationParts read_unnamed(const YAML::Node& root,
                              const std::string& file,
                              const RigHints& hints,
                              dive::FindingLog& findings) {
    if (!root.IsMap()) fail(file + " is no calibration that is read: " + kFormats);
    if (root["T_BS"]) fail(file + " is of a dive: give the folder that holds cam0 and cam1");
    CalibrationParts parts;
    parts.imu = read_kalibr_imu(root);
    if (parts.imu) return parts;
    if (auto read = read_opencv_calibration(root, file, hints, findings)) return std::move(*read);
    fail(file + " is no calibration that is read: " + kFormats);
}

CalibrationParts parts_of(std::string_view text,
                          const std::string& file,
                          const RigHints& hints,
                          dive::FindingLog& findings) {
    using enum dive::CalibrationProgram;
    if (is_mat(text)) return read_matlab_calibration(parse_mat(text, file), file, hints, findings);
    if (is_npz(text)) return read_unnamed(parse_npz(text, file), file, hints, findings);
    const auto format = dive::foreign_calibration(text);
    if (format && format->program == Colmap) return read_colmap_cameras(text, file);
    const YAML::Node root = parse(text);
    if (!format || format->program == OpenCv || !root.IsMap())
        return read_unnamed(root, file, hints, findings);
    CalibrationParts parts;
    if (format->program == Kalibr) return read_kalibr_chain(root, file, hints, findings);
    if (format->program == Kwiver) return read_kwiver_calibration(root, file, hints, findings);
    parts.infos.push_back(read_camera_info_yaml(root, file));
    return parts;
}

CalibrationParts parts_of_file(const CalibrationText& file,
                               const RigHints& hints,
                               dive::FindingLog& findings) {
    const std::string name = dive::printable(file.name);
    try {
        return parts_of(file.bytes, name, hints, findings);
    } catch (const YAML::Exception& error) {
        const std::string line =
            error.mark.is_null() ? "" : ":" + std::to_string(error.mark.line + 1);
        fail(name + line + " cannot be read as a calibration: " + dive::printable(error.msg) +
             ": " + kFormats);
    }
}

void check_number(std::size_t num_files) {
    if (num_files == 0 || num_files > kMaxFiles)
        throw Error(ErrorCode::InvalidArgument,
                    "a calibration is 1 to " + std::to_string(kMaxFiles) + " files: " + kFormats);
}

fs::path root_of(const fs::path& dive) {
    const bool is_root = dive.filename() == "mav0" || fs::exists(dive / "cam0");
    return is_root ? dive : dive / "mav0";
}

}  // namespace

RigFiles read_rig(const std::vector<fs::path>& files,
                  dive::FindingLog& findings,
                  const RigHints& hints) {
    std::error_code unknown;
    if (files.size() == 1 && fs::is_directory(files[0], unknown))
        return rig_of_folder(files[0], findings);
    check_number(files.size());
    std::vector<CalibrationText> texts;
    texts.reserve(files.size());
    for (const fs::path& file : files) texts.push_back({file.string(), text_of(file)});
    return rig_of_texts(texts, findings, hints);
}

bool is_calibration(std::string_view bytes) {
    if (is_mat(bytes) || is_npz(bytes) || dive::foreign_calibration(bytes)) return true;
    const auto has = [&](std::string_view key) {
        return bytes.find(key) != std::string_view::npos;
    };
    return has("gyroscope_noise_density") && !has("T_BS");  // Kalibr's IMU, not that of a dive
}

RigFiles rig_of_texts(const std::vector<CalibrationText>& files,
                      dive::FindingLog& findings,
                      const RigHints& hints) {
    check_number(files.size());
    CalibrationParts parts;
    for (const CalibrationText& file : files)
        add_parts(parts_of_file(file, hints, findings), file.name, parts);
    try {
        return assemble_rig(parts, hints, findings);
    } catch (const Error& error) {
        throw Error(error.code(), dive::printable(files[0].name) + ": " + error.what());
    }
}

void write_rig(const RigFiles& rig, const fs::path& dive) {
    const std::vector<std::pair<const char*, std::optional<std::string>>> sensors = {
        {"cam0", rig.cam0_yaml}, {"cam1", rig.cam1_yaml}, {"imu0", rig.imu_yaml}};
    const fs::path root = root_of(dive);
    for (const auto& [sensor, yaml] : sensors)
        if (yaml && fs::exists(root / sensor / "sensor.yaml"))
            throw Error(ErrorCode::Conflict,
                        (root / sensor / "sensor.yaml").string() +
                            " exists: remove it, or choose another folder by --out");
    for (const auto& [sensor, yaml] : sensors) {
        if (!yaml) continue;
        std::error_code failure;
        fs::create_directories(root / sensor, failure);  // writing says what is wrong
        base::write_file(root / sensor / "sensor.yaml", *yaml);
    }
}

}  // namespace divemesh::recording
