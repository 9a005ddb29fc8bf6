#include "worker/recording/import_recording.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "tests/paths.hpp"
#include "tests/worker/recording/bag_writer.hpp"
#include "tests/worker/recording/import_fixture.hpp"
#include "tests/worker/recording/message_writer.hpp"
#include "worker/dive/csv.hpp"
#include "worker/dive/dive.hpp"
#include "worker/dive/sensor_tables.hpp"

namespace divemesh::recording {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}

cv::Mat pixels_of(const fs::path& file) {
    return cv::imread(file.string(), cv::IMREAD_UNCHANGED | cv::IMREAD_IGNORE_ORIENTATION);
}

// A plain grey image whose pixels differ.
std::string grey_pixels(std::uint32_t num_pixels) {
    std::string pixels;
    for (std::uint32_t i = 0; i < num_pixels; ++i) pixels += static_cast<char>(7 * i);
    return pixels;
}

class ImportRecordingTest : public ImportFixture<RecordingImport, ImportOptions> {
protected:
    ImportOptions options_for(const std::string& bytes) {
        std::ofstream(folder_ / "recording", std::ios::binary) << bytes;
        ImportOptions options;
        options.recording = folder_ / "recording";
        options.out = folder_ / "dive";
        return options;
    }
};

// The first frames of a shared dive and its IMU, as messages.
class SharedDive {
public:
    static constexpr std::size_t kNumFrames = 30;

    explicit SharedDive(fs::path mav0) : mav0_(std::move(mav0)) {
        dive::for_each_csv_row(text_of(mav0_ / "cam0" / "data.csv"),
                               [&](std::int64_t, std::span<const std::string_view> fields) {
                                   if (images_.size() < kNumFrames)
                                       images_.emplace_back(*dive::parse_integer(fields[0]),
                                                            std::string(fields[1]));
                               });
        dive::FindingLog findings;
        imu_ = dive::parse_imu(text_of(mav0_ / "imu0" / "data.csv"), "imu", findings);
    }

    const auto& images() const { return images_; }
    const auto& imu() const { return imu_; }
    fs::path image(const char* camera, const std::string& name) const {
        return mav0_ / camera / "data" / name;
    }

    // Adds the messages as a recorder does: each some time after it was measured.
    template <typename Writer, typename ImageBytes>
    void add_messages(Writer& writer, Wire wire, const ImageBytes& image_bytes) const {
        constexpr std::int64_t kLate_ns = 3'000'000;
        const std::int64_t end_ns = images_.back().first;
        std::size_t next_image = 0;
        for (const types::ImuSample& sample : imu_) {
            if (sample.timestamp_ns > end_ns) break;
            while (images_[next_image].first < sample.timestamp_ns) {
                const auto& [time_ns, name] = images_[next_image++];
                add_pair(writer, time_ns, kLate_ns, name, image_bytes);
            }
            const auto& rates = sample.angular_velocity_imu;
            const auto& force = sample.acceleration_imu;
            writer.add_message(3,
                               sample.timestamp_ns + kLate_ns,
                               imu_message(wire,
                                           sample.timestamp_ns,
                                           {rates.x(), rates.y(), rates.z()},
                                           {force.x(), force.y(), force.z()}));
        }
        for (; next_image < images_.size(); ++next_image)
            add_pair(writer,
                     images_[next_image].first,
                     kLate_ns,
                     images_[next_image].second,
                     image_bytes);
    }

private:
    template <typename Writer, typename ImageBytes>
    void add_pair(Writer& writer,
                  std::int64_t time_ns,
                  std::int64_t late_ns,
                  const std::string& name,
                  const ImageBytes& image_bytes) const {
        writer.add_message(1, time_ns + late_ns, image_bytes(time_ns, image("cam0", name)));
        writer.add_message(2, time_ns + late_ns, image_bytes(time_ns, image("cam1", name)));
        writer.end_chunk();
    }

    fs::path mav0_;
    std::vector<std::pair<std::int64_t, std::string>> images_;
    std::vector<types::ImuSample> imu_;
};

void expect_same_imu(const fs::path& csv, const SharedDive& truth) {
    dive::FindingLog findings;
    const auto imu = dive::parse_imu(text_of(csv), "imu", findings);
    ASSERT_GT(imu.size(), 500U);
    for (std::size_t i = 0; i < imu.size(); ++i) {
        EXPECT_EQ(imu[i].timestamp_ns, truth.imu()[i].timestamp_ns);
        EXPECT_EQ(imu[i].angular_velocity_imu, truth.imu()[i].angular_velocity_imu);
        EXPECT_EQ(imu[i].acceleration_imu, truth.imu()[i].acceleration_imu);
    }
    EXPECT_GE(imu.back().timestamp_ns, truth.images().back().first - 5'000'000);
}

class ImportSharedDiveTest : public ImportRecordingTest {
protected:
    void SetUp() override {
        if (!fs::exists(tank_)) GTEST_SKIP() << tank_ << " is missing";
    }
    void expect_dive_opens(const fs::path& path) {
        const auto opened = dive::Dive::open(path, folder_.path());
        EXPECT_EQ(opened->num_frames(), SharedDive::kNumFrames);
        EXPECT_FALSE(opened->imu().empty());
        EXPECT_FALSE(has_error(opened->findings()));
        for (const Finding& finding : opened->findings())
            EXPECT_EQ(finding.severity, Severity::Info) << finding.code << ' ' << finding.message;
    }
    fs::path tank_ = shared_data("tank");
};

TEST_F(ImportSharedDiveTest, ABagOfPixelsIsTheSameDive) {
    const SharedDive truth(tank_ / "mav0");
    BagWriter writer("lz4");
    writer.add_connection(1, "/cam0/image_raw", "sensor_msgs/Image");
    writer.add_connection(2, "/cam1/image_raw", "sensor_msgs/Image");
    writer.add_connection(3, "/imu0", "sensor_msgs/Imu");
    truth.add_messages(writer, Wire::Ros1, [](std::int64_t time_ns, const fs::path& file) {
        const cv::Mat image = pixels_of(file);
        const auto* pixels = reinterpret_cast<const char*>(image.data);
        return image_message(Wire::Ros1,
                             time_ns,
                             image.channels() == 3 ? "bgr8" : "mono8",
                             static_cast<std::uint32_t>(image.cols),
                             static_cast<std::uint32_t>(image.rows),
                             {pixels, image.total() * image.elemSize()});
    });
    ImportOptions options = options_for(writer.finished());
    options.calibration = {tank_};
    const ImportCounts counts = imported(options);
    EXPECT_EQ(counts.num_left, 30);
    EXPECT_EQ(counts.num_right, 30);
    for (const auto& [time_ns, name] : truth.images())
        for (const char* camera : {"cam0", "cam1"}) {
            const cv::Mat image = pixels_of(options.out / "mav0" / camera / "data" /
                                            (std::to_string(time_ns) + ".png"));
            const cv::Mat expected = pixels_of(truth.image(camera, name));
            ASSERT_EQ(image.size(), expected.size());
            EXPECT_EQ(cv::norm(image, expected, cv::NORM_INF), 0.0) << name;
        }
    expect_same_imu(options.out / "mav0" / "imu0" / "data.csv", truth);
    expect_dive_opens(options.out);
}

TEST_F(ImportSharedDiveTest, AnMcapOfCompressedImagesIsTheSameDiveToTheByte) {
    const SharedDive truth(tank_ / "mav0");
    for (const Wire wire : {Wire::LittleCdr, Wire::BigCdr}) {
        McapBytes writer("zstd");
        const std::string image_type = "sensor_msgs/msg/CompressedImage";
        writer.add_channel(1, "/left/image_raw/compressed", image_type, "cdr");
        writer.add_channel(2, "/right/image_raw/compressed", image_type, "cdr");
        writer.add_channel(3, "/imu/data", "sensor_msgs/msg/Imu", "cdr");
        truth.add_messages(writer, wire, [&](std::int64_t time_ns, const fs::path& file) {
            return compressed_image_message(wire, time_ns, text_of(file));
        });
        const std::string bytes = writer.finished();
        ImportOptions options = options_for(bytes);
        options.calibration = {tank_ / "mav0"};
        options.out = folder_ / (wire == Wire::BigCdr ? "big" : "little");
        EXPECT_EQ(imported(options).num_left, 30);
        for (const auto& [time_ns, name] : truth.images())
            for (const char* camera : {"cam0", "cam1"})
                EXPECT_EQ(text_of(options.out / "mav0" / camera / "data" /
                                  (std::to_string(time_ns) + ".jpg")),
                          text_of(truth.image(camera, name)));
        expect_same_imu(options.out / "mav0" / "imu0" / "data.csv", truth);
        expect_dive_opens(options.out);
        EXPECT_NE(text_of(options.out / "dive.json").find(sha256_hex(bytes)), std::string::npos);
    }
}

// A pair of cameras whose geometry is known: rectified by two rotations, 0.12 m apart.
class InfoPair {
public:
    const Eigen::Matrix3d R_rect_cam0 =
        Eigen::AngleAxisd(0.02, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    const Eigen::Matrix3d R_rect_cam1 =
        Eigen::AngleAxisd(-0.03, Eigen::Vector3d(2, -1, 1).normalized()).toRotationMatrix();

    std::string recording(const std::string& image, std::int64_t left_stamp_ns = 5'000'000'000) {
        BagWriter writer;
        writer.add_connection(1, "/left/" + image, "sensor_msgs/Image");
        writer.add_connection(2, "/right/" + image, "sensor_msgs/Image");
        writer.add_connection(3, "/left/camera_info", "sensor_msgs/CameraInfo");
        writer.add_connection(4, "/right/camera_info", "sensor_msgs/CameraInfo");
        writer.add_connection(5, "/imu", "sensor_msgs/Imu");
        writer.add_message(3, 1, info(R_rect_cam0, 0.0));
        writer.add_message(4, 1, info(R_rect_cam1, baseline_m));
        writer.add_message(5, 2, imu_message(Wire::Ros1, 2, {0, 0, 0}, {0, 0, 9.8}));
        writer.add_message(
            1, 6'000'000'000, image_message(Wire::Ros1, left_stamp_ns, "mono8", 64, 48, pixels));
        writer.add_message(
            2, 6'000'000'000, image_message(Wire::Ros1, 5'000'000'000, "mono8", 64, 48, pixels));
        return writer.finished();
    }

    double baseline_m = 0.12;
    std::string model = "plumb_bob";
    std::vector<double> distortion = {-0.1, 0.01, 0.001, -0.002, 0.0};
    std::uint32_t width_px = 64;
    std::string pixels = grey_pixels(64 * 48);

private:
    std::string info(const Eigen::Matrix3d& R_rect_cam, double shift_m) const {
        const Eigen::Matrix3d by_rows = R_rect_cam.transpose();
        return camera_info_message(
            Wire::Ros1,
            width_px,
            48,
            model,
            distortion,
            {std::vector<double>{60, 0, 31, 0, 61, 24, 0, 0, 1},
             std::vector<double>(by_rows.data(), by_rows.data() + 9),
             std::vector<double>{55, 0, 30, -55 * shift_m, 0, 55, 23, 0, 0, 0, 1, 0}});
    }
};

TEST_F(ImportRecordingTest, CameraInfoOfRawImagesGivesLensesAndTheRelativePose) {
    InfoPair pair;
    const ImportOptions options = options_for(pair.recording("image_raw"));
    EXPECT_EQ(imported(options).num_left, 1);
    EXPECT_TRUE(has_code("imu_left_out"));
    EXPECT_FALSE(fs::exists(options.out / "mav0" / "imu0"));
    dive::FindingLog findings;
    const RigFiles rig = rig_of_folder(options.out, findings);
    EXPECT_EQ(rig.cam0.camera.fy_px, 61.0);
    EXPECT_EQ(rig.cam0.camera.cx_px, 31.0);
    EXPECT_EQ(rig.cam0.camera.distortion_coefficients[3], -0.002);
    // Both rectified frames are parallel, the right one 0.12 m along x of the left one.
    const Eigen::Isometry3d T_cam0_cam1 = rig.cam0.T_body_cam.inverse() * rig.cam1.T_body_cam;
    const Eigen::Vector3d point_cam1(0.3, -0.2, 1.7);
    const Eigen::Vector3d seen_by_left = pair.R_rect_cam0 * (T_cam0_cam1 * point_cam1);
    const Eigen::Vector3d seen_by_right = pair.R_rect_cam1 * point_cam1;
    EXPECT_LT((seen_by_left - seen_by_right - Eigen::Vector3d(0.12, 0, 0)).norm(), 1e-12);
}

TEST_F(ImportRecordingTest, CameraInfoOfRectifiedImagesGivesThePinholesOfP) {
    InfoPair pair;
    const ImportOptions options = options_for(pair.recording("image_rect"));
    imported(options);
    dive::FindingLog findings;
    const RigFiles rig = rig_of_folder(options.out, findings);
    EXPECT_EQ(rig.cam1.camera.fx_px, 55.0);
    EXPECT_EQ(rig.cam1.camera.cy_px, 23.0);
    EXPECT_EQ(rig.cam1.camera.distortion, types::Distortion::None);
    EXPECT_LT((rig.cam1.T_body_cam.translation() - Eigen::Vector3d(0.12, 0, 0)).norm(), 1e-15);
    EXPECT_TRUE(rig.cam1.T_body_cam.linear().isIdentity(1e-15));
}

TEST_F(ImportRecordingTest, TheShiftOfKalibrPutsTheImuOnTheClockOfTheCameras) {
    ImportOptions options = options_for(InfoPair().recording("image_raw"));
    options.calibration = {folder_ / "camchain.yaml"};
    std::ofstream(options.calibration[0]) << small_camchain("-0.004");
    EXPECT_EQ(imported(options).num_imu, 1);
    EXPECT_TRUE(has_code("calibration_time_offset"));
    dive::FindingLog findings;
    const auto imu =
        dive::parse_imu(text_of(options.out / "mav0" / "imu0" / "data.csv"), "imu", findings);
    EXPECT_EQ(imu.at(0).timestamp_ns, 2 + 4'000'000);
    // A row that would be before 1970 is left out.
    std::ofstream(options.calibration[0]) << small_camchain("0.004");
    options.out = folder_ / "later";
    EXPECT_EQ(imported(options).num_imu, 0);
}

TEST_F(ImportRecordingTest, ACalibrationWithoutASizeIsForTheRecordedImages) {
    ImportOptions options = options_for(InfoPair().recording("image_raw"));
    options.calibration = {folder_ / "rig.yml"};
    std::ofstream(options.calibration[0]) << "%YAML:1.0\n---\nK1: [60, 0, 31, 0, 61, 24, 0, 0, 1]\n"
                                             "K2: [62, 0, 30, 0, 63, 23, 0, 0, 1]\n"
                                             "R: [0, 0, 0]\nT: [-12, 0, 0]\n";
    EXPECT_NE(refusal_of(options).find("--calibration-unit"), std::string::npos);
    options.metres_per_unit = 1e-2;
    imported(options);
    dive::FindingLog findings;
    const RigFiles rig = rig_of_folder(options.out, findings);
    EXPECT_EQ(rig.cam0.camera.width_px, 64);
    EXPECT_EQ(rig.cam1.camera.height_px, 48);
    EXPECT_EQ(rig.cam1.camera.fy_px, 63.0);
    EXPECT_LT((rig.cam1.T_body_cam.translation() - Eigen::Vector3d(0.12, 0, 0)).norm(), 1e-15);
}

TEST_F(ImportRecordingTest, AMessageWithoutAStampHasTheTimeOfRecording) {
    const ImportOptions options = options_for(InfoPair().recording("image_raw", 0));
    imported(options);
    EXPECT_TRUE(fs::exists(options.out / "mav0" / "cam0" / "data" / "6000000000.png"));
    EXPECT_TRUE(has_code("stamp_missing"));
}

TEST_F(ImportRecordingTest, ACalibrationThatDoesNotFitIsRefusedWithWhatToDo) {
    const std::vector<std::function<void(InfoPair&)>> faults = {
        [](InfoPair& pair) { pair.baseline_m = 0.0; },
        [](InfoPair& pair) { pair.baseline_m = -0.12; },
        [](InfoPair& pair) { pair.model = "a\ncamera_model: b"; },
        [](InfoPair& pair) { pair.distortion.assign(1000, 0.5); },
        [](InfoPair& pair) { pair.distortion.assign(12, 0.01); },  // thin prism
        [](InfoPair& pair) { pair.distortion[0] = std::nan(""); },
        [](InfoPair& pair) { pair.width_px = 640; }};
    for (std::size_t i = 0; i < faults.size(); ++i) {
        InfoPair pair;
        faults[i](pair);
        EXPECT_GT(refusal_of(options_for(pair.recording("image_raw"))).size(), 40U) << i;
    }
}

TEST_F(ImportRecordingTest, AFolderThatIsNotEmptyStaysAsItIs) {
    const ImportOptions options = options_for(InfoPair().recording("image_raw"));
    imported(options);
    const std::string before = text_of(options.out / "dive.json");
    EXPECT_THROW(imported(options), Error);
    EXPECT_EQ(text_of(options.out / "dive.json"), before);
}

}  // namespace
}  // namespace divemesh::recording
