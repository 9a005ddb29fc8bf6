#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/temporary_folder.hpp"
#include "tests/worker/dive/finding_matcher.hpp"
#include "tests/worker/dive/tiny_dive.hpp"
#include "worker/dive/intake.hpp"

namespace divemesh::dive {
namespace {

class SensorFoldersTest : public testing::Test {
protected:
    std::vector<Finding> findings() {
        return examine_dive(tiny_.folder(), folder_ / "scratch", base::ignore_progress).findings;
    }
    void rename(const std::string& from, const std::string& to) const {
        std::filesystem::rename(tiny_.folder() / "mav0" / from, tiny_.folder() / "mav0" / to);
    }
    void write_imu(std::int64_t period_ns) const {
        std::string rows;
        for (int i = -10; i < 100; ++i)
            rows += std::to_string(TinyDive::kFirst_ns + i * period_ns) +
                    ",0.01,-0.02,0.03,0.1,0.2,9.8\n";
        tiny_.write("mav0/imu0/data.csv", rows);
    }

    const TemporaryFolder folder_;
    const TinyDive tiny_{folder_ / "dive"};
};

TEST_F(SensorFoldersTest, AFolderWithAlmostTheNameOfAMissingSensorIsAWarning) {
    for (const char* const name : {"imu", "IMU0", "Imu", "imu1"}) {
        rename("imu0", name);
        EXPECT_THAT(findings(),
                    HasFinding(Severity::Warning, "sensor_left_out", "there is no mav0/imu0"))
            << name;
        rename(name, "imu0");
    }
}

TEST_F(SensorFoldersTest, ASecondImuAndOtherSensorsAreOnlyMentioned) {
    tiny_.write("mav0/imu1/data.csv", "");
    tiny_.write("mav0/sonar0/data.csv", "");
    tiny_.write("mav0/cam2/data.csv", "");

    const auto told = findings();

    EXPECT_THAT(told, HasFinding(Severity::Info, "sensor_left_out", "imu1"));
    EXPECT_THAT(told, HasFinding(Severity::Info, "sensor_left_out", "sonar0"));
    EXPECT_THAT(told, HasFinding(Severity::Info, "camera_left_out", "cam2"));
    EXPECT_THAT(told, testing::Not(HasFinding(Severity::Warning, "sensor_left_out", "")));
}

TEST_F(SensorFoldersTest, AnImuWithoutItsMountingIsTakenForTheBodyWithAWarning) {
    EXPECT_THAT(findings(), testing::Not(HasFinding(Severity::Warning, "mounting_assumed", "")));
    tiny_.remove("mav0/imu0/sensor.yaml");
    EXPECT_THAT(findings(), HasFinding(Severity::Warning, "mounting_assumed", "imu0/sensor.yaml"));
}

TEST_F(SensorFoldersTest, AnImuThatRecordedNothingIsAWarning) {
    for (const char* const table : {"", "#timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z\n"}) {
        tiny_.write("mav0/imu0/data.csv", table);
        EXPECT_THAT(findings(), HasFinding(Severity::Warning, "imu_missing", "has no rows"));
    }
}

TEST_F(SensorFoldersTest, AnImuWithTooFewReadingsIsAWarning) {
    write_imu(90'000'000);
    EXPECT_THAT(findings(), testing::Not(HasFinding(Severity::Warning, "imu_slow", "")));
    write_imu(200'000'000);
    EXPECT_THAT(findings(), HasFinding(Severity::Warning, "imu_slow", "every 0.20 s"));
}

}  // namespace
}  // namespace divemesh::dive
