#include "worker/recording/recorded_dive.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/temporary_folder.hpp"
#include "tests/worker/recording/bag_writer.hpp"
#include "tests/worker/recording/message_writer.hpp"
#include "worker/dive/dive.hpp"
#include "worker/dive/refusal.hpp"

namespace divemesh::recording {
namespace {

namespace fs = std::filesystem;

std::string pattern(std::uint32_t num_pixels) {
    std::string pixels;
    for (std::uint32_t i = 0; i < num_pixels; ++i) pixels += static_cast<char>(31 * i + i / 64);
    return pixels;
}

std::string pinhole_info(double shift_m) {
    return camera_info_message(
        Wire::Ros1,
        64,
        48,
        "plumb_bob",
        {0, 0, 0, 0, 0},
        {std::vector<double>{60, 0, 32, 0, 60, 24, 0, 0, 1},
         std::vector<double>{1, 0, 0, 0, 1, 0, 0, 0, 1},
         std::vector<double>{60, 0, 32, -60 * shift_m, 0, 60, 24, 0, 0, 0, 1, 0}});
}

// A bag of three pairs and an IMU of which it is not told where it is.
std::string bag_of_pairs(bool with_calibration) {
    constexpr std::int64_t kSecond_ns = 1'000'000'000;
    BagWriter writer;
    writer.add_connection(1, "/left/image_raw", "sensor_msgs/Image");
    writer.add_connection(2, "/right/image_raw", "sensor_msgs/Image");
    writer.add_connection(5, "/imu", "sensor_msgs/Imu");
    if (with_calibration) {
        writer.add_connection(3, "/left/camera_info", "sensor_msgs/CameraInfo");
        writer.add_connection(4, "/right/camera_info", "sensor_msgs/CameraInfo");
        writer.add_message(3, 1, pinhole_info(0.0));
        writer.add_message(4, 1, pinhole_info(0.1));
    }
    for (std::int64_t time_ns = kSecond_ns; time_ns <= 3 * kSecond_ns; time_ns += kSecond_ns) {
        const auto image = image_message(Wire::Ros1, time_ns, "mono8", 64, 48, pattern(64 * 48));
        writer.add_message(1, time_ns, image);
        writer.add_message(2, time_ns, image);
        writer.add_message(5, time_ns, imu_message(Wire::Ros1, time_ns, {0, 0, 0}, {0, 0, 9.8}));
        writer.end_chunk();
    }
    return writer.finished();
}

class RecordedDiveTest : public testing::Test {
protected:
    fs::path file_of(const std::string& name, const std::string& bytes) {
        std::ofstream(folder_ / name, std::ios::binary) << bytes;
        return folder_ / name;
    }
    fs::path turned(const fs::path& recording, const std::string& scratch) {
        return as_dive(recording, folder_ / scratch, base::ignore_progress);
    }

    TemporaryFolder folder_;
};

TEST_F(RecordedDiveTest, ABagOpensAsTheDiveThatItHoldsAndTellsWhatTheImportFound) {
    const fs::path dive = turned(file_of("a.bag", bag_of_pairs(true)), "scratch");
    const auto opened = dive::Dive::open(dive, folder_ / "opened");
    EXPECT_EQ(opened->num_frames(), 3);
    EXPECT_NEAR(opened->rig().baseline_m(), 0.1, 1e-12);
    int num_told = 0;
    for (const Finding& finding : opened->findings())
        if (finding.code == "imu_left_out" && finding.severity == Severity::Warning) ++num_told;
    EXPECT_EQ(num_told, 1);
}

TEST_F(RecordedDiveTest, TheSameBytesAreTheSameDiveWhateverTheFileIsCalled) {
    std::string bytes = bag_of_pairs(true);
    bytes.resize(bytes.size() - 100);  // its findings name a place in the file
    const auto hash_of = [&](const std::string& name) {
        const fs::path dive = turned(file_of(name, bytes), "scratch of " + name);
        return dive::Dive::open(dive, folder_ / "opened")->content_sha256();
    };
    const std::string hash = hash_of("first.bag");
    EXPECT_EQ(hash, hash_of("0123abcd"));
    bytes = bag_of_pairs(true);
    EXPECT_NE(hash, hash_of("whole.bag"));
}

TEST_F(RecordedDiveTest, ARecordingThatDoesNotTellItsCalibrationIsRefusedWithTheWayOut) {
    const fs::path recording = file_of("a.bag", bag_of_pairs(false));
    try {
        turned(recording, "scratch");
        FAIL() << "it was not refused";
    } catch (const dive::Refusal& refusal) {
        EXPECT_EQ(refusal.finding().code, "recording_unclear");
        EXPECT_NE(refusal.finding().remedy.find("divemesh import"), std::string::npos);
    }
    EXPECT_FALSE(fs::exists(folder_ / "scratch/imported"));
}

TEST_F(RecordedDiveTest, FoldersArchivesAndWhatIsMissingAreLeftToTheDive) {
    for (const fs::path& path :
         {folder_ / ".", file_of("a.zip", "PK\3\4"), file_of("empty", ""), folder_ / "missing"})
        EXPECT_EQ(turned(path, "scratch"), path);
    EXPECT_FALSE(fs::exists(folder_ / "scratch"));
}

TEST_F(RecordedDiveTest, ACancelledImportEndsAsCancelled) {
    const fs::path recording = file_of("a.bag", bag_of_pairs(true));
    const auto cancel = [](const Progress&) { throw Error(ErrorCode::Cancelled, "cancelled"); };
    try {
        as_dive(recording, folder_ / "scratch", cancel);
        FAIL() << "it was not cancelled";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::Cancelled);
    }
    EXPECT_FALSE(fs::exists(folder_ / "scratch/imported"));
}

}  // namespace
}  // namespace divemesh::recording
