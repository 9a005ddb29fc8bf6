#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "tests/paths.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/worker/recording/bag_writer.hpp"
#include "tests/worker/recording/db3_writer.hpp"
#include "tests/worker/recording/message_writer.hpp"
#include "worker/dive/csv.hpp"
#include "worker/dive/sensor_tables.hpp"
#include "worker/recording/import_recording.hpp"

namespace divemesh::recording {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kNumPairs = 60;

std::string bytes_of(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}

// Writes the first pairs of a dive and its IMU up to there, all of the IMU first.
template <typename Writer>
void write_messages(Writer& writer, const fs::path& mav0) {
    std::vector<std::pair<std::int64_t, std::string>> images;
    dive::for_each_csv_row(bytes_of(mav0 / "cam0" / "data.csv"),
                           [&](std::int64_t, std::span<const std::string_view> fields) {
                               if (images.size() < kNumPairs)
                                   images.emplace_back(*dive::parse_integer(fields[0]), fields[1]);
                           });
    dive::FindingLog findings;
    for (const auto& sample : dive::parse_imu(bytes_of(mav0 / "imu0/data.csv"), "imu", findings)) {
        if (sample.timestamp_ns > images.back().first) break;
        const auto& rates = sample.angular_velocity_imu;
        const auto& force = sample.acceleration_imu;
        writer.add_message(3,
                           sample.timestamp_ns,
                           imu_message(Wire::LittleCdr,
                                       sample.timestamp_ns,
                                       {rates.x(), rates.y(), rates.z()},
                                       {force.x(), force.y(), force.z()}));
    }
    for (const auto& [time_ns, name] : images)
        for (const int camera : {0, 1})
            writer.add_message(
                static_cast<std::uint16_t>(camera + 1),
                time_ns,
                compressed_image_message(
                    Wire::LittleCdr,
                    time_ns,
                    bytes_of(mav0 / ("cam" + std::to_string(camera)) / "data" / name)));
}

// Returns the bytes of all files of a dive but dive.json, which names the recording.
std::map<std::string, std::string> files_of_dive(const fs::path& dive) {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(dive))
        if (entry.is_regular_file() && entry.path().filename() != "dive.json")
            files[fs::relative(entry.path(), dive).string()] = bytes_of(entry.path());
    return files;
}

TEST(Db3ImportTest, ABagInSqliteIsTheSameDiveAsOneInMcap) {
    const fs::path tank = shared_data("tank");
    if (!fs::exists(tank)) GTEST_SKIP() << tank << " is missing";
    const TemporaryFolder folder;
    const std::string image_type = "sensor_msgs/msg/CompressedImage";
    fs::create_directory(folder / "bag");
    {
        McapBytes mcap("lz4");
        Db3Writer db3(folder / "bag/bag_0.db3");
        mcap.add_channel(1, "/left/image_raw/compressed", image_type, "cdr");
        mcap.add_channel(2, "/right/image_raw/compressed", image_type, "cdr");
        mcap.add_channel(3, "/imu/data", "sensor_msgs/msg/Imu", "cdr");
        db3.add_channel(1, "/left/image_raw/compressed", image_type);
        db3.add_channel(2, "/right/image_raw/compressed", image_type);
        db3.add_channel(3, "/imu/data", "sensor_msgs/msg/Imu");
        write_messages(mcap, tank / "mav0");
        write_messages(db3, tank / "mav0");
        std::ofstream(folder / "bag.mcap", std::ios::binary) << mcap.finished();
    }
    std::map<std::string, std::string> expected;
    for (const char* recording : {"bag.mcap", "bag/bag_0.db3", "bag/"}) {
        ImportOptions options;
        options.recording = folder / recording;
        options.calibration = {tank};
        options.out = folder / "dive";
        RecordingImport import(options, base::ignore_progress);
        const ImportCounts counts = import.write(base::ignore_progress);
        EXPECT_EQ(counts.num_left, static_cast<std::int64_t>(kNumPairs));
        EXPECT_EQ(counts.num_right, static_cast<std::int64_t>(kNumPairs));
        EXPECT_GT(counts.num_imu, 500);
        EXPECT_TRUE(import.findings().empty());
        const auto files = files_of_dive(options.out);
        if (expected.empty()) expected = files;
        EXPECT_EQ(files, expected) << recording;
        fs::remove_all(options.out);
    }
}

}  // namespace
}  // namespace divemesh::recording
