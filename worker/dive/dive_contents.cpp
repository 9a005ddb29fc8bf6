#include "worker/dive/dive_contents.hpp"

#include <algorithm>

#include "worker/base/text.hpp"
#include "worker/dive/calibration.hpp"
#include "worker/dive/clock_set_back.hpp"
#include "worker/dive/dive_json.hpp"
#include "worker/dive/entry_name.hpp"
#include "worker/dive/sensor_tables.hpp"
#include "worker/dive/sensor_yaml.hpp"

namespace divemesh::dive {
namespace {

constexpr std::int64_t kMaxJsonBytes = std::int64_t{16} << 20;
constexpr std::int64_t kMaxMarkersBytes = std::int64_t{4} << 20;
constexpr const char* kSensors[] = {
    "cam0", "cam1", "imu0", "ahrs0", "pressure0", "state_groundtruth_estimate0"};

class ContentsReader {
public:
    ContentsReader(const DiveFiles& files, const DiveLimits& limits, FindingLog& findings)
        : files_(files), limits_(limits), findings_(findings) {}

    DiveContents read() {
        read_json();
        report_unknown_sensors();
        read_sensors();
        read_pairs();
        read_rig();
        check_times();
        return std::move(contents_);
    }

private:
    void read_json();
    void report_unknown_sensors();
    void read_sensors();
    void read_pairs();
    void mend_clock(std::vector<CameraRow>& left, std::vector<CameraRow>& right);
    void read_rig();
    void to_imu_frame(const Eigen::Isometry3d& T_body_imu);
    void check_interruption();
    void check_times();
    template <typename Samples>
    void check_coverage(const Samples& samples, const std::string& sensor, const std::string& file);

    std::optional<std::string> read_text(const std::string& file, std::int64_t max_bytes);
    std::vector<CameraRow> read_camera_rows(const std::string& camera);
    std::optional<CalibratedCamera> read_camera(const std::string& camera);
    std::optional<SensorYaml> read_yaml(const std::string& file);
    // Returns T_BS of a sensor; its sensor.yaml may be missing.
    Eigen::Isometry3d mounting(const std::string& sensor);

    const DiveFiles& files_;
    const DiveLimits& limits_;
    FindingLog& findings_;
    DiveContents contents_;
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
    if (const auto text = read_text("dive.json", kMaxJsonBytes))
        contents_.info = parse_dive_info(*text, findings_);
    if (const auto text = read_text("measurements.json", kMaxJsonBytes))
        contents_.known_distances = parse_known_distances(*text, findings_);
    if (const auto text = read_text("markers.json", kMaxMarkersBytes))
        contents_.markers = parse_markers(*text, findings_);
}

void ContentsReader::report_unknown_sensors() {
    for (const std::string& sensor : files_.sensors()) {
        if (std::find(std::begin(kSensors), std::end(kSensors), sensor) != std::end(kSensors))
            continue;
        const std::string what = sensor.starts_with("cam") ? "camera" : "sensor";
        findings_.info(what + "_left_out",
                       "mav0/" + printable(sensor),
                       "the " + what + " " + printable(sensor) + " is not used");
    }
}

void ContentsReader::read_sensors() {
    const auto text = [this](const std::string& sensor) {
        return read_text("mav0/" + sensor + "/data.csv", limits_.max_file_bytes);
    };
    const auto name = [](const std::string& sensor) { return "mav0/" + sensor + "/data.csv"; };
    if (const auto csv = text("imu0")) contents_.imu = parse_imu(*csv, name("imu0"), findings_);
    if (const auto csv = text("ahrs0")) contents_.ahrs = parse_ahrs(*csv, name("ahrs0"), findings_);
    if (const auto csv = text("pressure0"))
        contents_.pressure = parse_pressure(*csv, name("pressure0"), findings_);
    const std::string truth = "state_groundtruth_estimate0";
    if (const auto csv = text(truth))
        contents_.ground_truth = parse_ground_truth(*csv, name(truth), findings_);
    if (contents_.imu.empty() && contents_.ahrs.empty())
        findings_.info("imu_missing",
                       "mav0/imu0",
                       "there is no IMU, so the trajectory comes from vision alone");
}

std::vector<CameraRow> ContentsReader::read_camera_rows(const std::string& camera) {
    const std::string file = "mav0/" + camera + "/data.csv";
    const auto text = read_text(file, limits_.max_file_bytes);
    if (!text) {
        if (!files_.has(file))
            findings_.error(camera + "_missing",
                            file,
                            "there is no " + file +
                                ": a dive needs a left (cam0) and a right "
                                "(cam1) camera",
                            "Put the list of images (timestamp [ns],filename) there.");
        return {};
    }
    auto rows = parse_camera_rows(*text, camera, findings_);
    if (rows.empty())
        findings_.error("dive_empty",
                        file,
                        file + " lists no image",
                        "Check the recorder: it recorded no frames.");
    return rows;
}

void ContentsReader::read_pairs() {
    auto left = read_camera_rows("cam0");
    auto right = read_camera_rows("cam1");
    mend_clock(left, right);
    contents_.pairs = match_pairs(left, right, findings_);
}

// Mends the timestamps of all tables that share the recorder's clock.
void ContentsReader::mend_clock(std::vector<CameraRow>& left, std::vector<CameraRow>& right) {
    std::vector<TableStamps> tables;
    const auto add = [&](const std::string& sensor, auto& rows) {
        if (rows.empty()) return;
        TableStamps& table = tables.emplace_back(TableStamps{"mav0/" + sensor + "/data.csv", {}});
        for (auto& row : rows) table.timestamps_ns.push_back(&row.timestamp_ns);
    };
    add("cam0", left);
    add("cam1", right);
    add("imu0", contents_.imu);
    add("ahrs0", contents_.ahrs);
    add("pressure0", contents_.pressure);
    undo_set_backs(tables, findings_);
}

std::optional<SensorYaml> ContentsReader::read_yaml(const std::string& file) {
    const auto text = read_text(file, kMaxYamlBytes);
    return text ? parse_sensor_yaml(*text, file, findings_) : std::nullopt;
}

std::optional<CalibratedCamera> ContentsReader::read_camera(const std::string& camera) {
    const std::string file = "mav0/" + camera + "/sensor.yaml";
    if (!files_.has(file))
        findings_.error("calibration_missing",
                        file,
                        "there is no " + file,
                        "Calibrate the rig and put the calibration of both cameras there.");
    const auto yaml = read_yaml(file);
    return yaml ? calibrated_camera(*yaml, file, findings_) : std::nullopt;
}

Eigen::Isometry3d ContentsReader::mounting(const std::string& sensor) {
    const std::string file = "mav0/" + sensor + "/sensor.yaml";
    const auto yaml = read_yaml(file);
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
    contents_.has_rig = true;
    if (rig.cam0.width_px != rig.cam1.width_px || rig.cam0.height_px != rig.cam1.height_px)
        findings_.error("calibration_resolution",
                        "mav0/cam1/sensor.yaml",
                        "cam0 and cam1 have different resolutions",
                        "Record both cameras with the same resolution.");
}

// Converts samples from the frames of the sensors to that of the IMU.
void ContentsReader::to_imu_frame(const Eigen::Isometry3d& T_body_imu) {
    if (!contents_.ahrs.empty()) {
        const Eigen::Isometry3d T_ahrs_imu = mounting("ahrs0").inverse() * T_body_imu;
        const Eigen::Quaterniond q_ahrs_imu(T_ahrs_imu.linear());
        for (types::OrientationSample& sample : contents_.ahrs)
            sample.q_world_imu = (sample.q_world_imu * q_ahrs_imu).normalized();
    }
    if (contents_.ground_truth.empty()) return;
    const Eigen::Isometry3d T_truth_imu =
        mounting("state_groundtruth_estimate0").inverse() * T_body_imu;
    for (types::StampedPose& pose : contents_.ground_truth)
        pose.T_world_imu = pose.T_world_imu * T_truth_imu;
}

template <typename Samples>
void ContentsReader::check_coverage(const Samples& samples,
                                    const std::string& sensor,
                                    const std::string& file) {
    if (samples.empty() || contents_.pairs.empty()) return;
    const std::int64_t first = contents_.pairs.front().timestamp_ns;
    const std::int64_t last = contents_.pairs.back().timestamp_ns;
    const std::int64_t begin = samples.front().timestamp_ns;
    const std::int64_t end = samples.back().timestamp_ns;
    const std::string ranges = "it runs from " + std::to_string(begin) + " to " +
                               std::to_string(end) + ", the images from " + std::to_string(first) +
                               " to " + std::to_string(last);
    if (end < first || begin > last)
        return findings_.error(
            sensor + "_no_overlap",
            file,
            file + " does not overlap the images in time: " + ranges,
            "Record both with the same clock, or remove the file from the dive.");
    const double covered_s =
        static_cast<double>(std::min(end, last) - std::max(begin, first)) * 1e-9;
    const double dive_s = static_cast<double>(last - first) * 1e-9;
    if (covered_s < 0.98 * dive_s)
        findings_.warning(sensor + "_partial",
                          file,
                          file + " covers " + base::fixed(covered_s, 2) + " s of " +
                              base::fixed(dive_s, 2) + " s of images: " + ranges,
                          "Start this sensor before the cameras and stop it after them.");
}

// Tells of the longest time in which nothing was recorded at all: neither images nor IMU.
void ContentsReader::check_interruption() {
    constexpr std::int64_t kMinInterruption_ns = 2'000'000'000;
    const auto& pairs = contents_.pairs;
    const auto after =
        std::adjacent_find(pairs.begin(), pairs.end(), [&](const FramePair& a, const FramePair& b) {
            return b.timestamp_ns - a.timestamp_ns > kMinInterruption_ns &&
                   std::none_of(contents_.imu.begin(),
                                contents_.imu.end(),
                                [&](const types::ImuSample& sample) {
                                    const auto margin_ns = (b.timestamp_ns - a.timestamp_ns) / 10;
                                    return sample.timestamp_ns > a.timestamp_ns + margin_ns &&
                                           sample.timestamp_ns < b.timestamp_ns - margin_ns;
                                });
        });
    if (after == pairs.end()) return;
    findings_.warning(
        "recording_interrupted",
        "mav0/cam0/data.csv",
        "nothing was recorded for " +
            base::fixed(static_cast<double>((after + 1)->timestamp_ns - after->timestamp_ns) * 1e-9,
                        1) +
            " s after frame " + std::to_string(after - pairs.begin()) +
            ": the recorder paused, or its clock was set forward. What follows is a segment of its "
            "own unless it comes back to a place that was seen before",
        "Do not pause in mid-dive and do not set the clock, or begin a new dive.");
}

void ContentsReader::check_times() {
    const std::string data = "/data.csv";
    check_coverage(contents_.imu, "imu", "mav0/imu0" + data);
    check_coverage(contents_.ahrs, "ahrs", "mav0/ahrs0" + data);
    check_coverage(contents_.pressure, "pressure", "mav0/pressure0" + data);
    check_interruption();
    check_coverage(
        contents_.ground_truth, "ground_truth", "mav0/state_groundtruth_estimate0" + data);
}

}  // namespace

DiveContents read_contents(const DiveFiles& files, const DiveLimits& limits, FindingLog& findings) {
    return ContentsReader(files, limits, findings).read();
}

}  // namespace divemesh::dive
