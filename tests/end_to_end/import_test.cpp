#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/end_to_end/service.hpp"
#include "tests/paths.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

class ImportTest : public testing::Test {
protected:
    // Writes a dive as MCAP; returns "" where the writer is not installed.
    fs::path write_recording(const fs::path& dive) {
        const fs::path scripts = source_directory() / "tests/end_to_end/js";
        if (!fs::exists(scripts / "node_modules/@mcap/core")) return {};
        const fs::path recording = service / "dive.mcap";
        Process node({"/usr/bin/env",
                      "node",
                      (scripts / "write_mcap.mjs").string(),
                      dive.string(),
                      recording.string()},
                     service / ".");
        EXPECT_EQ(node.wait(60s), 0) << node.stderr_text();
        return recording;
    }

    Service service;
};

// Returns the rows of a table as numbers; a name of an image is that of its timestamp.
std::vector<std::vector<double>> numbers_of(const fs::path& csv) {
    std::vector<std::vector<double>> rows;
    std::istringstream lines(read_text(csv));
    for (std::string line; std::getline(lines, line);) {
        if (line.empty() || line.front() == '#') continue;
        std::istringstream fields(line);
        std::vector<double>& row = rows.emplace_back();
        for (std::string field; std::getline(fields, field, ',');) row.push_back(std::stod(field));
    }
    return rows;
}

TEST_F(ImportTest, ARecordingByTheWriterOfMcapIsTheDiveThatItWasMadeOf) {
    const fs::path original = small_dive();
    const fs::path recording = write_recording(original);
    if (recording.empty()) GTEST_SKIP() << "run npm ci in tests/end_to_end/js first";
    const fs::path dive = service / "imported";
    const Outcome imported = service.run(
        {"import", recording.string(), "--calibration", original.string(), "--out", dive.string()},
        60s);
    ASSERT_EQ(imported.exit_code, 0) << imported.err;
    EXPECT_NE(imported.out.find("left camera"), std::string::npos) << imported.out;

    for (const char* sensor : {"cam0", "cam1", "imu0"}) {
        const fs::path table = fs::path("mav0") / sensor / "data.csv";
        EXPECT_EQ(numbers_of(dive / table), numbers_of(original / table)) << sensor;
    }
    int num_images = 0;
    for (const char* camera : {"cam0", "cam1"})
        for (const auto& image : fs::directory_iterator(original / "mav0" / camera / "data")) {
            const fs::path copy = dive / "mav0" / camera / "data" / image.path().filename();
            EXPECT_EQ(read_text(copy), read_text(image.path())) << copy;
            ++num_images;
        }
    EXPECT_GT(num_images, 10);
    EXPECT_EQ(service.run({"validate", dive.string()}, 60s).exit_code, 0);
}

TEST_F(ImportTest, AnUploadedRecordingIsReconstructedWithItsOwnCalibration) {
    const fs::path recording = write_recording(small_dive());
    if (recording.empty()) GTEST_SKIP() << "run npm ci in tests/end_to_end/js first";
    service.start_server(1);
    const Outcome uploaded =
        service.run({"upload", recording.string(), "--wait", "--set", "surface=false"}, 240s);
    EXPECT_EQ(uploaded.exit_code, 0) << uploaded.err;
    const nlohmann::json dive = service.dives().at(0);
    EXPECT_EQ(dive.at("state"), "ready");
    EXPECT_EQ(dive.at("num_frames"), numbers_of(small_dive() / "mav0/cam0/data.csv").size());
    // Nothing says where the IMU is, so vision alone gives the scale.
    EXPECT_EQ(service.wait_for_reconstruction("succeeded", 1s).at("verdict"),
              "usable_with_restrictions");
    // The same bytes are known by their hash alone.
    EXPECT_EQ(service.run({"upload", recording.string(), "--no-job"}, 60s).exit_code, 0);
    EXPECT_EQ(service.dives().size(), 1U);
}

}  // namespace
}  // namespace divemesh
