#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/paths.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/dive/dive.hpp"

namespace divemesh::dive {
namespace {

struct SharedDive {
    const char* name;
    int num_frames;
    int num_imu_samples;
    double baseline_m;
};

void PrintTo(const SharedDive& dive, std::ostream* out) { *out << dive.name; }

class SharedDivesTest : public testing::TestWithParam<SharedDive> {};

TEST_P(SharedDivesTest, OpensWithoutErrorAndStreamsItsFirstFrames) {
    const auto folder = shared_data(GetParam().name);
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no shared data at " << folder;
    const TemporaryFolder scratch;

    const auto dive = Dive::open(folder, scratch.path());

    EXPECT_FALSE(has_error(dive->findings()));
    for (const Finding& finding : dive->findings())
        EXPECT_EQ(finding.severity, Severity::Info) << finding.message;
    EXPECT_EQ(dive->num_frames(), GetParam().num_frames);
    EXPECT_EQ(dive->imu().size(), static_cast<std::size_t>(GetParam().num_imu_samples));
    EXPECT_NEAR(dive->rig().baseline_m(), GetParam().baseline_m, 5e-4);
    EXPECT_FALSE(dive->ground_truth().empty());
    for (int i = 0; i < 5; ++i) {
        const auto frame = dive->next_frame();
        ASSERT_TRUE(frame.has_value());
        EXPECT_EQ(frame->index, i);
        EXPECT_EQ(frame->left.size(), frame->right.size());
    }
    EXPECT_EQ(dive->num_skipped_frames(), 0);
}

// Copies 30 pairs of a dive, every fifth from the 450th on: 2 pairs a second.
void copy_slowly(const std::filesystem::path& from, const std::filesystem::path& to) {
    for (const char* camera : {"cam0", "cam1"}) {
        const auto source = from / "mav0" / camera;
        const auto target = to / "mav0" / camera;
        std::filesystem::create_directories(target / "data");
        std::filesystem::copy_file(source / "sensor.yaml", target / "sensor.yaml");
        std::ifstream rows(source / "data.csv");
        std::ofstream kept(target / "data.csv");
        std::string line;
        std::getline(rows, line);
        kept << line << '\n';
        for (int i = 0; std::getline(rows, line) && i < 600; ++i) {
            if (i < 450 || i % 5 != 0) continue;
            kept << line << '\n';
            std::string file = line.substr(line.find(',') + 1);
            file.erase(file.find_last_not_of("\r ") + 1);
            std::filesystem::copy_file(source / "data" / file, target / "data" / file);
        }
    }
}

// So few corners are found again after half a second that the images hardly confirm the timestamps,
// and a lag of their motion was taken for a difference of the clocks.
TEST(SlowDiveTest, CamerasWhoseTimestampsAgreeHaveOneClock) {
    const auto folder = shared_data("barge");
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no shared data at " << folder;
    const TemporaryFolder scratch;
    copy_slowly(folder, scratch / "slow");

    const auto dive = Dive::open(scratch / "slow", scratch / "unpacked");

    EXPECT_EQ(dive->num_frames(), 30);
    for (const Finding& finding : dive->findings()) {
        EXPECT_NE(finding.code, "camera_clocks_differ") << finding.message;
        EXPECT_NE(finding.code, "frames_unsynchronised") << finding.message;
    }
}

INSTANTIATE_TEST_SUITE_P(Shared,
                         SharedDivesTest,
                         testing::Values(SharedDive{"euroc_mh01", 160, 1790, 0.110},
                                         SharedDive{"tank", 150, 3181, 0.120},
                                         SharedDive{"barge", 700, 14181, 0.120}),
                         [](const auto& dive) { return std::string(dive.param.name); });

}  // namespace
}  // namespace divemesh::dive
