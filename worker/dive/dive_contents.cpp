#include "worker/dive/dive_contents.hpp"

#include <algorithm>
#include <array>
#include <cctype>

#include "worker/base/text.hpp"
#include "worker/camera/virtual_camera.hpp"
#include "worker/dive/calibration.hpp"
#include "worker/dive/calibration_format.hpp"
#include "worker/dive/common_clock.hpp"
#include "worker/dive/dive_json.hpp"
#include "worker/dive/entry_name.hpp"
#include "worker/dive/image_names.hpp"
#include "worker/dive/position_tables.hpp"
#include "worker/dive/sensor_tables.hpp"
#include "worker/dive/sensor_yaml.hpp"
#include "worker/dive/stamp_check.hpp"
#include "worker/dive/stated_water.hpp"

namespace divemesh::dive {
namespace {

constexpr std::int64_t kMaxJsonBytes = std::int64_t{16} << 20;
constexpr std::int64_t kMaxMarkersBytes = std::int64_t{4} << 20;
constexpr std::int64_t kMaxPositionBytes = std::int64_t{64} << 20;
constexpr const char* kVelocities = "velocity0";
constexpr const char* kSensors[] = {
    "cam0", "cam1", "imu0", "ahrs0", "pressure0", kVelocities, "state_groundtruth_estimate0"};

std::string table_of(const std::string& sensor) { return "mav0/" + sensor + "/data.csv"; }

// Returns true for position0 to position9.
bool is_position_source(const std::string& sensor) {
    return sensor.size() == 9 && sensor.starts_with("position") && sensor.back() >= '0' &&
           sensor.back() <= '9';
}

// Returns a sensor that is missing and whose name differs from that of a folder by case or number
// alone, as imu differs from imu0; nullptr if there is none.
const char* sensor_meant_by(const std::string& folder, const DiveFiles& files) {
    const auto kind = [](std::string_view name) {
        std::string letters;
        for (const char c : name)
            if (c < '0' || c > '9')
                letters += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        return letters;
    };
    const std::vector<std::string> there = files.sensors();
    const auto is_meant = [&](const char* sensor) {
        return kind(folder) == kind(sensor) &&
               std::find(there.begin(), there.end(), sensor) == there.end();
    };
    const auto sensor = std::find_if(std::begin(kSensors), std::end(kSensors), is_meant);
    return sensor == std::end(kSensors) ? nullptr : *sensor;
}

std::size_t count_errors(const FindingLog& findings) {
    return static_cast<std::size_t>(
        std::count_if(findings.all().begin(), findings.all().end(), [](const Finding& finding) {
            return finding.severity == Severity::Error;
        }));
}

class ContentsReader {
public:
    ContentsReader(const DiveFiles& files, const DiveLimits& limits, FindingLog& findings)
        : files_(files), limits_(limits), findings_(findings) {}

    DiveContents read() {
        read_json();
        report_unknown_sensors();
        read_motion_sensors();
        read_cameras();
        read_other_sensors();
        read_outside_positions();
        read_rig();
        return std::move(contents_);
    }

private:
    void read_json();
    void report_unknown_sensors();
    void read_motion_sensors();
    void read_cameras();
    void read_other_sensors();
    void read_outside_positions();
    void read_rig();
    void move_into_water();
    void to_imu_frame(const Eigen::Isometry3d& T_body_imu);

    std::optional<std::string> read_text(const std::string& file, std::int64_t max_bytes);
    std::optional<std::string> read_table(const std::string& sensor);
    std::vector<CameraRow> read_camera_rows(const std::string& camera);
    std::optional<CalibratedCamera> read_camera(const std::string& camera);
    void report_no_calibration(const std::string& file);
    std::optional<SensorYaml> read_yaml(const std::string& file);
    // Returns T_BS of a sensor; its sensor.yaml may be missing.
    Eigen::Isometry3d mounting(const std::string& sensor);

    const DiveFiles& files_;
    const DiveLimits& limits_;
    FindingLog& findings_;
    DiveContents contents_;
    std::optional<types::Port> port_;  // of dive.json
    CommonClock clock_{findings_};     // of the tables read so far
};

std::optional<std::string> ContentsReader::read_text(const std::string& file,
                                                     std::int64_t max_bytes) {
    if (!files_.has(file)) return std::nullopt;
    auto text = files_.read(file, max_bytes);
    if (!text)
        findings_.error("file_too_large",
                        file,
                        file + " has " + std::to_string(files_.size_bytes(file)) +
                            " bytes, more than the " + std::to_string(max_bytes) + " allowed",
                        "Check the program that wrote it.");
    return text;
}

void ContentsReader::read_json() {
    if (const auto text = read_text("dive.json", kMaxJsonBytes)) {
        contents_.info = parse_dive_info(*text, findings_);
        if (const auto port = parse_port(*text, findings_))
            port_ = port_of(*port, "dive.json", findings_);
    }
    if (const auto text = read_text("measurements.json", kMaxJsonBytes))
        contents_.known_distances = parse_known_distances(*text, findings_);
    if (const auto text = read_text("markers.json", kMaxMarkersBytes))
        contents_.markers = parse_markers(*text, findings_);
}

void ContentsReader::report_unknown_sensors() {
    for (const std::string& sensor : files_.sensors()) {
        if (is_position_source(sensor) ||
            std::find(std::begin(kSensors), std::end(kSensors), sensor) != std::end(kSensors))
            continue;
        const std::string what = sensor.starts_with("cam") ? "camera" : "sensor";
        const std::string folder = "mav0/" + printable(sensor);
        const std::string text = "the " + what + " " + printable(sensor) + " is not used";
        const char* const meant = sensor_meant_by(sensor, files_);
        if (meant)
            findings_.warning(
                what + "_left_out",
                folder,
                text + ": there is no mav0/" + meant,
                std::string("If it is the sensor of the rig, rename the folder to ") + meant + ".");
        else
            findings_.info(what + "_left_out", folder, text);
    }
}

std::optional<std::string> ContentsReader::read_table(const std::string& sensor) {
    return read_text(table_of(sensor), limits_.max_file_bytes);
}

// Reads what has the most rows a second: it shows best where the clock was set back.
void ContentsReader::read_motion_sensors() {
    if (const auto csv = read_table("imu0")) {
        const std::size_t num_findings = findings_.all().size();
        contents_.imu = parse_imu(*csv, table_of("imu0"), findings_, &clock_);
        if (contents_.imu.empty() && findings_.all().size() == num_findings)
            findings_.warning("imu_missing",
                              table_of("imu0"),
                              table_of("imu0") + " has no rows",
                              "Check the recorder: it did not record the IMU.");
    }
    if (const auto csv = read_table("ahrs0"))
        contents_.ahrs = parse_ahrs(*csv, table_of("ahrs0"), findings_, &clock_);
    if (contents_.imu.empty() && contents_.ahrs.empty())
        findings_.info("imu_missing",
                       "mav0/imu0",
                       "there is no IMU, so the trajectory comes from vision alone");
}

void ContentsReader::read_cameras() {
    contents_.left_rows = read_camera_rows("cam0");
    contents_.right_rows = read_camera_rows("cam1");
}

void ContentsReader::read_other_sensors() {
    if (const auto csv = read_table("pressure0"))
        contents_.pressure = parse_pressure(*csv, table_of("pressure0"), findings_, &clock_);
    const std::string truth = "state_groundtruth_estimate0";
    if (const auto csv = read_table(truth))
        contents_.ground_truth = parse_ground_truth(*csv, table_of(truth), findings_, &clock_);
}

void ContentsReader::read_outside_positions() {
    types::OutsidePositions& outside = contents_.outside;
    for (const std::string& sensor : files_.sensors()) {
        if (!is_position_source(sensor)) continue;
        const auto csv = read_text(table_of(sensor), kMaxPositionBytes);
        if (!csv) continue;
        const std::string file = "mav0/" + sensor + "/sensor.yaml";
        auto source =
            describe_source(sensor, read_yaml(file).value_or(SensorYaml()), file, findings_);
        if (!source) continue;
        source->samples = parse_positions(*csv, source->epsg, table_of(sensor), findings_, &clock_);
        if (!source->samples.empty()) outside.sources.push_back(std::move(*source));
    }
    if (const auto csv = read_text(table_of(kVelocities), kMaxPositionBytes))
        outside.velocities = parse_velocities(*csv, table_of(kVelocities), findings_, &clock_);
    if (const auto text = read_text("control_points.json", kMaxMarkersBytes))
        parse_control_points(*text, outside, findings_);
    to_common_system(outside, findings_);
}

std::vector<CameraRow> ContentsReader::read_camera_rows(const std::string& camera) {
    const std::string file = table_of(camera);
    const auto text = read_text(file, limits_.max_file_bytes);
    const std::size_t num_errors = count_errors(findings_);
    std::vector<CameraRow> rows;
    if (text) rows = parse_camera_rows(*text, camera, findings_, &clock_);
    complete_image_names(rows, files_, camera, findings_);
    if (!rows.empty() || count_errors(findings_) > num_errors) return rows;
    rows = rows_by_image_names(files_, camera, findings_);
    if (!rows.empty()) {
        // Names have no order but that of time: they show a step only if it is less than a period.
        const TableClock clock = find_clock_steps(timestamps_of(rows), clock_.known());
        take_off_steps(rows, clock);
        clock_.add(file, clock);
        return rows;
    }
    if (text)
        findings_.error("dive_empty",
                        file,
                        file + " lists no image",
                        "Check the recorder: it recorded no frames. The list has a row for each "
                        "image: timestamp [ns],filename.");
    else if (!files_.has(file))
        findings_.error(camera + "_missing",
                        file,
                        "there is no " + file +
                            ": a dive needs a left (cam0) and a right "
                            "(cam1) camera",
                        "Put the list of images (timestamp [ns],filename) there, or name the "
                        "images in mav0/" +
                            camera + "/data by their timestamps in nanoseconds.");
    return rows;
}

std::optional<SensorYaml> ContentsReader::read_yaml(const std::string& file) {
    const auto text = read_text(file, kMaxYamlBytes);
    return text ? parse_sensor_yaml(*text, file, findings_) : std::nullopt;
}

bool can_be_calibration(const std::string& name) {
    constexpr std::array<const char*, 5> kEndings = {".yaml", ".yml", ".json", ".xml", ".txt"};
    return std::any_of(kEndings.begin(), kEndings.end(), [&](const char* ending) {
        return name.ends_with(ending);
    });
}

// Says how to turn a calibration of another tool that lies beside the recording into sensor.yaml.
void ContentsReader::report_no_calibration(const std::string& file) {
    std::string found;
    std::string remedy = "Calibrate the rig and put the calibration of both cameras there.";
    for (const char* folder : {"", "mav0/"})
        for (const std::string& name : files_.names_in(folder)) {
            if (!found.empty() || !can_be_calibration(name)) continue;
            const auto text = files_.read(folder + name, kMaxYamlBytes);
            const auto foreign = text ? foreign_calibration(*text) : std::nullopt;
            if (!foreign) continue;
            found = "; " + printable(folder + name) + " is " + foreign->name;
            remedy = foreign->remedy;
        }
    findings_.error("calibration_missing", file, "there is no " + file + found, remedy);
}

std::optional<CalibratedCamera> ContentsReader::read_camera(const std::string& camera) {
    const std::string file = "mav0/" + camera + "/sensor.yaml";
    if (!files_.has(file)) report_no_calibration(file);
    const auto yaml = read_yaml(file);
    return yaml ? calibrated_camera(*yaml, file, findings_) : std::nullopt;
}

Eigen::Isometry3d ContentsReader::mounting(const std::string& sensor) {
    const std::string file = "mav0/" + sensor + "/sensor.yaml";
    const auto yaml = read_yaml(file);
    if (!yaml && !files_.has(file) && (sensor == "imu0" || sensor == "ahrs0"))
        findings_.warning("mounting_assumed",
                          file,
                          "there is no " + file + ": the axes of " + sensor +
                              " are taken for those of the body, in which T_BS of the cameras is",
                          "Put T_BS of the sensor there, and the noise of an IMU.");
    if (!yaml) return Eigen::Isometry3d::Identity();
    if (sensor == "imu0") contents_.rig.imu_noise = imu_noise(*yaml, file, findings_);
    return rigid_motion(*yaml, file, findings_).value_or(Eigen::Isometry3d::Identity());
}

void ContentsReader::read_rig() {
    const auto cam0 = read_camera("cam0");
    const auto cam1 = read_camera("cam1");
    if (!contents_.imu.empty()) contents_.rig.imu_noise = types::ImuNoise{};
    const Eigen::Isometry3d T_body_imu =
        contents_.imu.empty() ? (cam0 ? cam0->T_body_cam : Eigen::Isometry3d::Identity())
                              : mounting("imu0");
    to_imu_frame(T_body_imu);
    if (!cam0 || !cam1) return;
    check_stereo(*cam0, *cam1, findings_);
    types::Rig& rig = contents_.rig;
    rig.cam0 = cam0->camera;
    rig.cam1 = cam1->camera;
    rig.T_imu_cam0 = T_body_imu.inverse() * cam0->T_body_cam;
    rig.T_imu_cam1 = T_body_imu.inverse() * cam1->T_body_cam;
    move_into_water();
    contents_.has_rig = true;
    if (rig.cam0.width_px != rig.cam1.width_px || rig.cam0.height_px != rig.cam1.height_px)
        findings_.error("calibration_resolution",
                        "mav0/cam1/sensor.yaml",
                        "cam0 and cam1 have different resolutions",
                        "Record both cameras with the same resolution.");
}

// Has the cameras behind a port see through it into the water of dive.json.
void ContentsReader::move_into_water() {
    types::Rig& rig = contents_.rig;
    for (types::Camera* camera : {&rig.cam0, &rig.cam1})
        if (!camera->port && port_) camera->port = *port_;
    const auto needs_water = [](const types::Camera& camera) {
        return camera.port && camera.port->water_index == 0.0;
    };
    const double index = needs_water(rig.cam0) || needs_water(rig.cam1)
                             ? index_of_water(contents_.info, findings_)
                             : 0.0;
    camera::move_into_water(rig.cam0, rig.T_imu_cam0, index);
    camera::move_into_water(rig.cam1, rig.T_imu_cam1, index);
}

// Converts samples from the frames of the sensors to that of the IMU.
void ContentsReader::to_imu_frame(const Eigen::Isometry3d& T_body_imu) {
    if (!contents_.ahrs.empty()) {
        const Eigen::Isometry3d T_ahrs_imu = mounting("ahrs0").inverse() * T_body_imu;
        const Eigen::Quaterniond q_ahrs_imu(T_ahrs_imu.linear());
        for (types::OrientationSample& sample : contents_.ahrs)
            sample.q_world_imu = (sample.q_world_imu * q_ahrs_imu).normalized();
    }
    const Eigen::Isometry3d T_imu_body = T_body_imu.inverse();
    for (types::PositionSource& source : contents_.outside.sources)
        source.p_imu_instrument = T_imu_body * mounting(source.name).translation();
    if (!contents_.outside.velocities.empty())
        contents_.outside.T_imu_dvl = T_imu_body * mounting(kVelocities);
    if (contents_.ground_truth.empty()) return;
    const Eigen::Isometry3d T_truth_imu =
        mounting("state_groundtruth_estimate0").inverse() * T_body_imu;
    for (types::StampedPose& pose : contents_.ground_truth)
        pose.T_world_imu = pose.T_world_imu * T_truth_imu;
}

}  // namespace

DiveContents read_contents(const DiveFiles& files, const DiveLimits& limits, FindingLog& findings) {
    return ContentsReader(files, limits, findings).read();
}

}  // namespace divemesh::dive
