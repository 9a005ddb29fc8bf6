#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <sstream>
#include <string>
#include <utility>

#include "tests/temporary_folder.hpp"
#include "tests/worker/dive/finding_matcher.hpp"
#include "tests/worker/dive/tiny_dive.hpp"
#include "worker/dive/dive.hpp"
#include "worker/dive/intake.hpp"

namespace divemesh::dive {
namespace {

constexpr const char* kCam0Rows = "mav0/cam0/data.csv";
constexpr const char* kCam1Rows = "mav0/cam1/data.csv";
constexpr const char* kCam0Yaml = "mav0/cam0/sensor.yaml";
constexpr const char* kCam1Yaml = "mav0/cam1/sensor.yaml";
constexpr const char* kImuRows = "mav0/imu0/data.csv";

class BadRecordingTest : public testing::Test {
protected:
    IntakeReport report() {
        return examine_dive(tiny_.folder(), folder_ / "scratch", base::ignore_progress);
    }
    std::vector<Finding> findings() { return report().findings; }
    static std::string image(int index) { return "mav0/cam0/data/" + TinyDive::image_name(index); }
    void write_imu(const std::string& values, std::int64_t period_ns = 5'000'000) const {
        std::string rows;
        for (int i = -10; i < 100; ++i)
            rows += std::to_string(TinyDive::kFirst_ns + i * period_ns) + "," + values + "\n";
        tiny_.write(kImuRows, rows);
    }
    // Writes a reading a second that swings by `swing` around `middle`.
    void write_pressure(double middle,
                        double swing,
                        std::int64_t first = TinyDive::kFirst_ns,
                        std::int64_t second = 1'000'000'000) const {
        std::string rows;
        for (int i = -20; i < 40; ++i)
            rows += std::to_string(first + i * second) + "," +
                    std::to_string(middle + swing * std::sin(0.5 * i)) + "\n";
        tiny_.write("mav0/pressure0/data.csv", rows);
    }

    const TemporaryFolder folder_;
    const TinyDive tiny_{folder_ / "dive"};
};

TEST_F(BadRecordingTest, AGoodDiveHasNoErrorAndSaysWhatItIs) {
    const auto good = report();

    EXPECT_FALSE(has_error(good.findings)) << testing::PrintToString(good.findings);
    EXPECT_EQ(good.name, "Tiny");
    EXPECT_EQ(good.num_frames, TinyDive::kNumFrames);
    EXPECT_NEAR(good.duration_s, 0.4, 1e-9);
    EXPECT_EQ(good.content_sha256.sha256.size(), 64U);
    EXPECT_TRUE(good.thumbnail_jpeg.starts_with("\xff\xd8\xff"));
}

TEST_F(BadRecordingTest, ADiveWithoutCam1IsRefused) {
    tiny_.remove("mav0/cam1");

    EXPECT_THAT(findings(), HasFinding(Severity::Error, "cam1_missing", kCam1Rows));
}

TEST_F(BadRecordingTest, AThirdCameraIsReportedAndLeftOut) {
    tiny_.write("mav0/cam2/data.csv", "1,a.png\n");

    EXPECT_THAT(findings(), HasFinding(Severity::Info, "camera_left_out", "cam2"));
}

TEST_F(BadRecordingTest, AMissingCalibrationIsRefused) {
    tiny_.remove(kCam1Yaml);

    EXPECT_THAT(findings(), HasFinding(Severity::Error, "calibration_missing", kCam1Yaml));
}

TEST_F(BadRecordingTest, ACalibrationThatIsNoYamlIsRefusedWithItsLine) {
    tiny_.replace(kCam0Yaml, "resolution: [64, 48]", "resolution: [64, 48");

    EXPECT_THAT(findings(), HasFinding(Severity::Error, "calibration_unreadable", kCam0Yaml));
}

TEST_F(BadRecordingTest, YamlAliasesAndDepthAreRefused) {
    tiny_.write(kCam0Yaml, "a: &a [x, x]\nb: [*a, *a]\n");
    EXPECT_THAT(findings(), HasFinding(Severity::Error, "calibration_unreadable", "sensor.yaml:1"));

    tiny_.write(kCam0Yaml, "a: " + std::string(100'000, '[') + "\n");
    EXPECT_THAT(findings(), HasFinding(Severity::Error, "calibration_unreadable", kCam0Yaml));
}

// It is unknown which of the two values is meant.
TEST_F(BadRecordingTest, ACalibrationThatStatesSomethingTwiceIsRefused) {
    tiny_.replace(kCam0Yaml, "intrinsics:", "intrinsics: [51.0, 51.0, 32.0, 24.0]\nintrinsics:");
    EXPECT_THAT(findings(), HasFinding(Severity::Error, "calibration_unreadable", kCam0Yaml));
}

TEST_F(BadRecordingTest, HugeNumbersInACalibrationAreRefused) {
    tiny_.replace(kCam0Yaml, "[50.0, 50.0", "[1e999, 50.0");
    EXPECT_THAT(findings(), HasFinding(Severity::Error, "calibration_unreadable", "sensor.yaml:9"));
}

TEST_F(BadRecordingTest, ACalibrationThatCannotBeInvertedIsRefused) {
    tiny_.write(kCam0Yaml, camera_yaml("1,0,0,0, 0,0,0,0, 0,0,1,0, 0,0,0,1"));
    EXPECT_THAT(findings(), HasFinding(Severity::Error, "calibration_not_invertible", kCam0Yaml));

    tiny_.write(kCam0Yaml, camera_yaml("1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1"));
    tiny_.replace(kCam0Yaml, "[50.0, 50.0", "[0.0, 50.0");
    EXPECT_THAT(findings(), HasFinding(Severity::Error, "calibration_not_invertible", kCam0Yaml));
}

TEST_F(BadRecordingTest, LensDistortionThatFoldsTheImageIsRefused) {
    tiny_.replace(kCam0Yaml, "[-0.1, 0.01", "[-3.0, 0.01");

    EXPECT_THAT(findings(), HasFinding(Severity::Error, "calibration_not_invertible", kCam0Yaml));
}

TEST_F(BadRecordingTest, AnImageThatIsWrittenAgainIsSkippedAndNamed) {
    const auto name = [](const char* camera, int index) {
        return std::string("mav0/") + camera + "/data/" + TinyDive::image_name(index);
    };
    tiny_.write(name("cam0", 1), tiny_.read(name("cam0", 0)));  // both cameras
    tiny_.write(name("cam1", 1), tiny_.read(name("cam1", 0)));
    tiny_.write(name("cam1", 3), tiny_.read(name("cam1", 2)));  // one camera hangs

    const auto dive = Dive::open(tiny_.folder(), folder_ / "scratch");
    std::vector<int> shown;
    while (const auto frame = dive->next_frame()) shown.push_back(frame->index);

    EXPECT_EQ(shown, (std::vector<int>{0, 2, 4}));
    EXPECT_EQ(dive->num_skipped_frames(), 2);
    EXPECT_THAT(dive->findings(), HasFinding(Severity::Warning, "image_repeated", name("cam1", 3)));
}

TEST_F(BadRecordingTest, AFisheyeThatSeesBehindItselfIsTakenUnlessItsImageFolds) {
    tiny_.replace(
        kCam0Yaml, "distortion_model: radial-tangential", "distortion_model: equidistant");
    tiny_.replace(kCam0Yaml, "[50.0, 50.0", "[18.0, 18.0");
    tiny_.replace(kCam0Yaml, "[-0.1, 0.01", "[0.01, -0.001");
    EXPECT_THAT(findings(),
                testing::Not(HasFinding(Severity::Warning, "calibration_distortion", kCam0Yaml)));

    tiny_.replace(kCam0Yaml, "[0.01, -0.001", "[-1.0, -0.001");
    EXPECT_THAT(findings(), HasFinding(Severity::Error, "calibration_not_invertible", kCam0Yaml));
}

TEST_F(BadRecordingTest, AbsurdIntrinsicsAreRefused) {
    tiny_.replace(kCam0Yaml, "[50.0, 50.0, 32.0", "[50.0, 50.0, 320.0");
    EXPECT_THAT(findings(), HasFinding(Severity::Error, "calibration_intrinsics", kCam0Yaml));

    tiny_.replace(kCam0Yaml, "[50.0, 50.0", "[0.05, 0.05");
    EXPECT_THAT(findings(), HasFinding(Severity::Error, "calibration_intrinsics", kCam0Yaml));
}

TEST_F(BadRecordingTest, IntrinsicsInTheOrderOfACameraMatrixAreNamed) {
    tiny_.replace(kCam0Yaml, "[50.0, 50.0, 32.0, 24.0]", "[50.0, 32.0, 50.0, 24.0]");
    EXPECT_THAT(findings(),
                HasFinding(Severity::Error, "calibration_intrinsics", "order fu, cu, fv, cv"));
    // A lens for wide images, whose pixels are not square.
    tiny_.replace(kCam0Yaml, "[50.0, 32.0, 50.0, 24.0]", "[50.0, 37.5, 32.0, 24.0]");
    EXPECT_THAT(findings(),
                testing::Not(HasFinding(Severity::Error, "calibration_intrinsics", "")));
}

TEST_F(BadRecordingTest, ARotationThatIsNoneIsRefused) {
    tiny_.write(kCam1Yaml, camera_yaml("1,0.2,0,0.1, 0,1,0,0, 0,0,1,0, 0,0,0,1"));

    EXPECT_THAT(findings(), HasFinding(Severity::Error, "calibration_not_rigid", kCam1Yaml));
}

TEST_F(BadRecordingTest, ABaselineOfZeroOrInMillimetresIsRefused) {
    tiny_.write(kCam1Yaml, camera_yaml("1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1"));
    EXPECT_THAT(findings(), HasFinding(Severity::Error, "baseline_zero", kCam1Yaml));

    tiny_.write(kCam1Yaml, camera_yaml("1,0,0,100, 0,1,0,0, 0,0,1,0, 0,0,0,1"));
    EXPECT_THAT(findings(), HasFinding(Severity::Error, "baseline_absurd", kCam1Yaml));
}

TEST_F(BadRecordingTest, ABaselineOfTheWrongSignIsRefused) {
    tiny_.write(kCam1Yaml, camera_yaml("1,0,0,-0.1, 0,1,0,0, 0,0,1,0, 0,0,0,1"));

    EXPECT_THAT(findings(), HasFinding(Severity::Error, "baseline_sign", kCam1Yaml));
}

// A camera that looks along the body's x axis, as on a sledge: body x = camera z, y = -x, z = -y.
TEST_F(BadRecordingTest, InvertedExtrinsicsAreSaid) {
    const std::string right_cam0 = "0,0,1,0.3, -1,0,0,0.05, 0,-1,0,0, 0,0,0,1";
    const std::string right_cam1 = "0,0,1,0.3, -1,0,0,-0.05, 0,-1,0,0, 0,0,0,1";
    tiny_.write(kCam0Yaml, camera_yaml(right_cam0));
    tiny_.write(kCam1Yaml, camera_yaml(right_cam1));
    ASSERT_FALSE(has_error(findings()));

    tiny_.write(kCam0Yaml, camera_yaml("0,-1,0,0.05, 0,0,-1,0, 1,0,0,-0.3, 0,0,0,1"));
    tiny_.write(kCam1Yaml, camera_yaml("0,-1,0,-0.05, 0,0,-1,0, 1,0,0,-0.3, 0,0,0,1"));
    EXPECT_THAT(findings(),
                HasFinding(Severity::Error, "extrinsics_inverted", "T_BS looks inverted"));
}

TEST_F(BadRecordingTest, RepeatedAndBackwardStampsAreToldWithTheirLine) {
    const std::string third = std::to_string(TinyDive::kFirst_ns + 200'000'000LL);
    const std::string second = std::to_string(TinyDive::kFirst_ns + 100'000'000LL);
    tiny_.replace(kCam0Rows, third + "," + third, second + "," + third);
    EXPECT_THAT(findings(),
                HasFinding(Severity::Error, "cam0_timestamp_repeated", "cam0/data.csv:4"));

    tiny_.replace(kCam0Rows, second + "," + third, "5," + third);
    EXPECT_THAT(findings(),
                HasFinding(Severity::Error, "cam0_timestamp_backwards", "cam0/data.csv:4"));
}

TEST_F(BadRecordingTest, OneRepeatedImuStampIsOnlyAWarning) {
    const std::string rows = tiny_.read(kImuRows);
    const std::size_t last = rows.rfind('\n', rows.size() - 2);
    tiny_.write(kImuRows, rows + rows.substr(last + 1));

    EXPECT_THAT(findings(),
                HasFinding(Severity::Warning, "imu_timestamp_repeated", "imu0/data.csv:112"));
}

// One image was taken before, and 20 readings of the IMU.
TEST_F(BadRecordingTest, AClockThatWasSetBackAtTheStartMovesAllTablesTogether) {
    const std::string truth = "mav0/state_groundtruth_estimate0/data.csv";
    for (const std::string file : {kCam0Rows, kCam1Rows, kImuRows, truth.c_str()}) {
        std::istringstream rows(tiny_.read(file));
        std::string written;
        for (std::string row; std::getline(rows, row);) {
            const std::size_t comma = row.find(',');
            const bool is_after =
                row[0] != '#' && std::stoll(row) >= TinyDive::kFirst_ns + 50'000'000LL;
            written += is_after ? std::to_string(std::stoll(row) - 60'000'000'000LL) +
                                      row.substr(comma) + "\n"
                                : row + "\n";
        }
        tiny_.write(file, written);
    }

    const auto told = report();

    EXPECT_EQ(told.num_frames, TinyDive::kNumFrames);
    EXPECT_NEAR(told.duration_s, 0.4, 1e-9);
    EXPECT_THAT(told.findings, HasFinding(Severity::Warning, "clock_set_back", kImuRows));
    for (const Finding& finding : told.findings) {
        EXPECT_NE(finding.code, "clocks_disagree") << finding.where;
        EXPECT_FALSE(finding.code.ends_with("_partial")) << finding.where;
        EXPECT_FALSE(finding.code.ends_with("_no_overlap")) << finding.where;
    }
}

TEST_F(BadRecordingTest, LeftAndRightWithoutOverlapAreRefused) {
    std::string rows;
    for (int i = 0; i < TinyDive::kNumFrames; ++i)
        rows += std::to_string(TinyDive::kFirst_ns + 60'000'000'000LL + i * 100'000'000LL) + "," +
                TinyDive::image_name(i) + "\n";
    tiny_.write(kCam1Rows, rows);

    EXPECT_THAT(findings(), HasFinding(Severity::Error, "left_right_no_overlap", kCam1Rows));
}

TEST_F(BadRecordingTest, AnImageWithoutPartnerIsCounted) {
    const std::string rows = tiny_.read(kCam1Rows);
    tiny_.write(kCam1Rows, rows.substr(0, rows.rfind('\n', rows.size() - 2) + 1));

    const auto spoiled = report();

    EXPECT_THAT(spoiled.findings,
                HasFinding(Severity::Warning, "frames_unmatched", "1 left and 0 right"));
    EXPECT_EQ(spoiled.num_frames, TinyDive::kNumFrames - 1);
}

TEST_F(BadRecordingTest, ImagesWithoutAListAreFoundByTheirNames) {
    tiny_.remove(kCam0Rows);
    std::string stamps;
    for (int i = 0; i < TinyDive::kNumFrames; ++i)
        stamps += std::to_string(TinyDive::kFirst_ns + i * 100'000'000LL) + "\n";
    tiny_.write(kCam1Rows, stamps);

    const auto told = report();

    EXPECT_EQ(told.num_frames, TinyDive::kNumFrames);
    EXPECT_THAT(told.findings,
                HasFinding(Severity::Warning, "image_list_missing", "5 images are used"));
    EXPECT_THAT(told.findings,
                HasFinding(Severity::Warning, "image_names_completed", "5 of 5 rows"));
}

TEST_F(BadRecordingTest, ImagesThatWereConvertedAfterTheListWasWrittenAreFound) {
    std::string rows;
    for (int i = 0; i < TinyDive::kNumFrames; ++i) {
        const std::string name = TinyDive::image_name(i);
        rows += std::to_string(TinyDive::kFirst_ns + i * 100'000'000LL) + "," +
                name.substr(0, name.rfind('.')) + ".BMP\n";
    }
    tiny_.write(kCam0Rows, rows);

    const auto told = report();

    EXPECT_EQ(told.num_frames, TinyDive::kNumFrames);
    EXPECT_THAT(told.findings,
                HasFinding(Severity::Warning, "image_names_completed", "5 of 5 rows"));
    EXPECT_FALSE(has_error(told.findings));
}

TEST_F(BadRecordingTest, QuotedFieldsAreRead) {
    std::string rows = "\"timestamp\",\"filename\"\n";
    for (int i = 0; i < TinyDive::kNumFrames; ++i)
        rows += "\"" + std::to_string(TinyDive::kFirst_ns + i * 100'000'000LL) + "\",\"" +
                TinyDive::image_name(i) + "\"\n";
    tiny_.write(kCam0Rows, rows);

    const auto told = report();

    EXPECT_EQ(told.num_frames, TinyDive::kNumFrames);
    EXPECT_FALSE(has_error(told.findings));
}

TEST_F(BadRecordingTest, EmptyReadingsOfAnImuAreLeftOut) {
    std::string rows;
    for (int i = -20; i < 200; ++i) {
        rows += std::to_string(TinyDive::kFirst_ns + i * 2'500'000LL);
        rows += i % 2 == 0 ? ",0.1,0.2,0.3,,,\n" : ",,,,0.1,-9.8,0.2\n";
    }
    tiny_.write(kImuRows, rows);

    const auto told = findings();

    EXPECT_THAT(told, HasFinding(Severity::Warning, "imu_zeros", "220 rows are left out"));
    EXPECT_FALSE(has_error(told));
}

TEST_F(BadRecordingTest, ATransformOfThreeRowsIsRead) {
    for (const char* yaml : {kCam0Yaml, kCam1Yaml}) {
        tiny_.replace(yaml, "rows: 4", "rows: 3");
        std::string text = tiny_.read(yaml);
        const std::size_t end = text.find(']');
        std::size_t begin = end;
        for (int comma = 0; comma < 4; ++comma) begin = text.rfind(',', begin - 1);
        tiny_.write(yaml, text.erase(begin, end - begin));
    }

    EXPECT_FALSE(has_error(findings()));
}

TEST_F(BadRecordingTest, ACalibrationIndentedByTabsIsNamed) {
    tiny_.replace(kCam0Yaml, "  cols", "\tcols");

    EXPECT_THAT(findings(), HasFinding(Severity::Error, "calibration_unreadable", "by a tab"));
}

TEST_F(BadRecordingTest, AnAccelerometerWithReversedSignIsTold) {
    write_imu("0,0,0,0.1,-9.8,0.2");  // up is -y of the cameras
    EXPECT_THAT(findings(), testing::Not(HasFinding(Severity::Warning, "gravity_upside_down", "")));

    write_imu("0,0,0,-0.1,9.8,-0.2");
    EXPECT_THAT(findings(), HasFinding(Severity::Warning, "gravity_upside_down", "upside down"));
}

TEST_F(BadRecordingTest, DepthsWrittenAsNegativeNumbersAreTold) {
    std::string rows;
    for (int i = 0; i < TinyDive::kNumFrames; ++i)
        rows += std::to_string(TinyDive::kFirst_ns + i * 100'000'000LL) + ",-18.2\n";
    tiny_.write("mav0/pressure0/data.csv", rows);

    EXPECT_THAT(findings(), HasFinding(Severity::Warning, "pressure_sign", "5 of 5 depths"));
}

TEST_F(BadRecordingTest, PressuresInMillibarsAreRefused) {
    write_pressure(1813.0, 30.0);
    EXPECT_THAT(findings(), HasFinding(Severity::Error, "pressure_units", "mbar"));

    write_pressure(7.9, 0.3);
    EXPECT_THAT(findings(), testing::Not(HasFinding(Severity::Error, "pressure_units", "")));
}

TEST_F(BadRecordingTest, DepthsOfADeepVehicleAreTaken) {
    write_pressure(1813.0, 0.5);

    const auto told = findings();

    EXPECT_THAT(told, HasFinding(Severity::Info, "pressure_units", "if the dive was not as deep"));
    EXPECT_FALSE(has_error(told)) << testing::PrintToString(told);
}

TEST_F(BadRecordingTest, MicrosecondsOfASlowSensorAreToldByTheImages) {
    write_pressure(7.9, 0.3, TinyDive::kFirst_ns / 1000, 1'000'000);
    std::string truth;
    for (int i = -1; i < 10; ++i)
        truth += std::to_string(TinyDive::kFirst_ns / 1000 + i * 50'000) + ",0,0,0,1,0,0,0\n";
    tiny_.write("mav0/state_groundtruth_estimate0/data.csv", truth);

    const auto told = findings();

    for (const std::string sensor : {"pressure", "ground_truth"}) {
        EXPECT_THAT(told, HasFinding(Severity::Error, sensor + "_timestamp_unit", "microseconds"));
        EXPECT_THAT(told, testing::Not(HasFinding(Severity::Warning, sensor + "_no_overlap", "")));
    }
}

TEST_F(BadRecordingTest, AUnitThatThePeriodTellsIsToldOnce) {
    write_pressure(7.9, 0.3, TinyDive::kFirst_ns / 1'000'000'000, 1);

    const auto told = findings();

    EXPECT_EQ(std::count_if(told.begin(),
                            told.end(),
                            [](const Finding& finding) {
                                return finding.code == "pressure_timestamp_unit" ||
                                       finding.code == "pressure_no_overlap";
                            }),
              1)
        << testing::PrintToString(told);
}

TEST_F(BadRecordingTest, StampsInMillisecondsAreRefused) {
    std::string rows;
    for (int i = 0; i < TinyDive::kNumFrames; ++i)
        rows +=
            std::to_string(1'600'000'000'000LL + i * 100) + "," + TinyDive::image_name(i) + "\n";
    tiny_.write(kCam0Rows, rows);
    tiny_.write(kCam1Rows, rows);

    EXPECT_THAT(findings(), HasFinding(Severity::Error, "cam0_timestamp_unit", kCam0Rows));
}

TEST_F(BadRecordingTest, NanInTheImuIsToldWithItsLine) {
    tiny_.replace(kImuRows, "0.01,-0.02,0.03,0.1", "0.01,nan,0.03,0.1");
    EXPECT_THAT(findings(), HasFinding(Severity::Warning, "imu_not_finite", "imu0/data.csv:2"));

    write_imu("0,0,0,inf,0,9.8");
    EXPECT_THAT(findings(), HasFinding(Severity::Error, "imu_not_finite", "imu0/data.csv:1"));
}

TEST_F(BadRecordingTest, NumbersBeyondAllMeasureAreToldWithTheirLine) {
    for (const char* absurd : {"1e308", "-1e308", "2e9"}) {
        const std::string rows = tiny_.read(kImuRows);
        tiny_.replace(kImuRows, "0.01,-0.02,0.03,0.1", std::string("0.01,") + absurd + ",0.03,0.1");
        EXPECT_THAT(findings(), HasFinding(Severity::Warning, "imu_not_finite", "imu0/data.csv:2"))
            << absurd;
        tiny_.write(kImuRows, rows);
    }
    write_imu("0,0,0,1e400,0,9.8");  // too large for a double
    EXPECT_THAT(findings(), HasFinding(Severity::Error, "imu_row_malformed", "imu0/data.csv:1"));
}

TEST_F(BadRecordingTest, StampsBelowZeroOrBeyondAllNumbersAreTold) {
    for (const char* stamp : {"-1600000000000000000", "99999999999999999999", "1.6e18", "0x10"}) {
        std::string rows = tiny_.read(kImuRows);
        const auto line = rows.find('\n', rows.find('\n') + 1) + 1;  // without the heading
        tiny_.write(kImuRows, rows.insert(line, std::string(stamp) + ",0,0,0,0,0,9.8\n"));
        EXPECT_THAT(findings(),
                    HasFinding(Severity::Warning, "imu_row_malformed", "imu0/data.csv:3"))
            << stamp;
        tiny_.replace(kImuRows, std::string(stamp) + ",0,0,0,0,0,9.8\n", "");
    }
}

TEST_F(BadRecordingTest, ACellThatASpreadsheetWouldRunIsNoNumber) {
    for (const char* cell : {"=cmd|' /C calc'!A0", "(1)", "+1+1", "-1+1", "=1"}) {
        const std::string rows = tiny_.read(kImuRows);
        tiny_.replace(kImuRows, "0.01,-0.02,0.03,0.1", std::string("0.01,") + cell + ",0.03,0.1");
        const auto told = findings();
        EXPECT_THAT(told, HasFinding(Severity::Warning, "imu_row_malformed", "imu0/data.csv:2"))
            << cell;
        for (const Finding& finding : told)
            EXPECT_EQ((finding.where + finding.message + finding.remedy).find(cell),
                      std::string::npos)
                << "what is told quotes it: " << finding.message;
        tiny_.write(kImuRows, rows);
    }
}

TEST_F(BadRecordingTest, LinesWithNulAndLinesWithoutEndAreMalformedRows) {
    const std::string rows = tiny_.read(kImuRows);
    const std::string nul("1600000001000000000,0,0\0,0,0,0,9.8\n", 35);
    tiny_.write(kImuRows, rows + nul);
    EXPECT_THAT(findings(),
                HasFinding(Severity::Warning, "imu_row_malformed", "imu0/data.csv:112"));

    tiny_.write(kImuRows, rows + std::string(50'000'000, '1'));
    EXPECT_THAT(findings(),
                HasFinding(Severity::Warning, "imu_row_malformed", "imu0/data.csv:112"));
    tiny_.write(kImuRows, rows + std::string(50'000'000, ','));
    EXPECT_THAT(findings(),
                HasFinding(Severity::Warning, "imu_row_malformed", "imu0/data.csv:112"));
}

// Rows with the same path, also in another case: each row keeps its own name, and no file stands in
// for another.
TEST_F(BadRecordingTest, NamesThatDifferByCaseAreTwoFiles) {
    tiny_.write("DIVE.JSON", R"({"name": "Impostor"})");
    EXPECT_EQ(report().name, "Tiny");

    tiny_.replace(kCam0Rows, TinyDive::image_name(1), "A.PNG");
    EXPECT_THAT(findings(), HasFinding(Severity::Warning, "image_missing", "A.PNG"));
}

TEST_F(BadRecordingTest, AGapInTheImuIsTold) {
    std::string rows;
    for (int i = -10; i < 100; ++i)
        if (i < 20 || i > 40)
            rows += std::to_string(TinyDive::kFirst_ns + i * 5'000'000LL) + ",0,0,0,0,0,9.8\n";
    tiny_.write(kImuRows, rows);

    EXPECT_THAT(findings(), HasFinding(Severity::Warning, "imu_gap", "0.110 s"));
}

TEST_F(BadRecordingTest, AbsurdImuUnitsAreNamed) {
    write_imu("0,0,0,0.01,0.02,1.0");
    EXPECT_THAT(findings(), HasFinding(Severity::Error, "imu_units", "looks like g"));

    write_imu("12,-15,8,0.1,0.2,9.8");
    EXPECT_THAT(findings(), HasFinding(Severity::Error, "imu_units", "degrees/s"));

    write_imu("0,0,0,0.1,0.2,0.3");
    EXPECT_THAT(findings(), HasFinding(Severity::Error, "imu_units", "gravity"));

    write_imu("0.1,0.2,9.8,0.1,0.2,0.3");
    EXPECT_THAT(findings(), HasFinding(Severity::Error, "imu_units", "exchanged"));
}

TEST_F(BadRecordingTest, AnImuOfAnotherTimeIsNotUsed) {
    tiny_.write(kImuRows, "1000000000,0,0,0,0,0,9.8\n1005000000,0,0,0,0,0,9.8\n");

    EXPECT_THAT(findings(), HasFinding(Severity::Warning, "imu_no_overlap", kImuRows));
    EXPECT_FALSE(has_error(findings()));
}

TEST_F(BadRecordingTest, GroundTruthOfAnotherTimeIsNotUsed) {
    const std::string file = "mav0/state_groundtruth_estimate0/data.csv";
    tiny_.write(file, "1000000000,0,0,0,1,0,0,0\n2000000000,0,0,0,1,0,0,0\n");

    EXPECT_THAT(findings(), HasFinding(Severity::Warning, "ground_truth_no_overlap", file));
}

TEST_F(BadRecordingTest, ImagesOfAnotherSizeThanTheCalibrationAreRefused) {
    tiny_.replace(kCam0Yaml, "[64, 48]", "[128, 96]");
    tiny_.replace(kCam0Yaml, "[50.0, 50.0, 32.0, 24.0]", "[100.0, 100.0, 64.0, 48.0]");

    EXPECT_THAT(findings(), HasFinding(Severity::Error, "image_size", image(0)));
}

TEST_F(BadRecordingTest, ATruncatedPngIsSkippedCountedAndNamed) {
    const std::string bytes = tiny_.read(image(2));
    tiny_.write(image(2), bytes.substr(0, bytes.size() / 2));

    const auto spoiled = findings();

    EXPECT_THAT(spoiled, HasFinding(Severity::Warning, "image_undecodable", image(2)));
    EXPECT_THAT(spoiled, HasFinding(Severity::Warning, "frames_skipped", "1 of 5"));
    EXPECT_FALSE(has_error(spoiled));
    for (const Finding& finding : spoiled) EXPECT_NE(finding.remedy, "") << finding.code;
}

TEST_F(BadRecordingTest, AHugeHeaderIsRefusedWithoutDecoding) {
    std::string bytes = tiny_.read(image(1));
    const std::string huge("\x00\x00\xc3\x50", 4);  // 50000
    bytes.replace(16, 8, huge + huge);
    tiny_.write(image(1), bytes);

    EXPECT_THAT(findings(), HasFinding(Severity::Warning, "image_too_large", "50000x50000"));
}

TEST_F(BadRecordingTest, SixteenBitsAreReducedAndTold) {
    tiny_.write(image(1), png_of_size(64, 48, CV_16UC1));

    const auto spoiled = findings();

    EXPECT_THAT(spoiled, HasFinding(Severity::Warning, "image_16_bit", image(1)));
    EXPECT_FALSE(has_error(spoiled));
}

TEST_F(BadRecordingTest, BlackImagesAreRefused) {
    const std::string black = black_png(64, 48);
    for (int i = 0; i < TinyDive::kNumFrames; ++i) tiny_.write(image(i), black);

    EXPECT_THAT(findings(), HasFinding(Severity::Error, "images_black", "cam0"));
}

TEST_F(BadRecordingTest, AnEmptyDiveIsRefused) {
    tiny_.write(kCam0Rows, "#timestamp [ns],filename\n");
    tiny_.remove("mav0/cam0/data");

    EXPECT_THAT(findings(), HasFinding(Severity::Error, "dive_empty", kCam0Rows));
}

TEST_F(BadRecordingTest, AMissingImageIsSkippedAndNamed) {
    tiny_.remove(image(3));

    EXPECT_THAT(findings(), HasFinding(Severity::Warning, "image_missing", image(3)));
}

TEST_F(BadRecordingTest, NoImageThatDecodesIsAnError) {
    for (int i = 0; i < TinyDive::kNumFrames; ++i) tiny_.write(image(i), "GIF89a");

    const auto spoiled = findings();

    EXPECT_THAT(spoiled, HasFinding(Severity::Error, "no_frame_decodes", "none of the 5"));
    EXPECT_THAT(spoiled,
                HasFinding(Severity::Warning, "image_undecodable", "neither PNG nor JPEG"));
}

TEST_F(BadRecordingTest, ImagesOfAnotherFormatAreNamed) {
    using std::string_literals::operator""s;
    const std::pair<std::string, std::string> formats[] = {{"BMP", "BM6\0\x0c\0"s},
                                                           {"TIFF", "II*\0\x08\0\0\0"s},
                                                           {"TIFF", "MM\0*\0\0\0\x08"s},
                                                           {"WebP", "RIFF\x24\0\0\0WEBPVP8 "s},
                                                           {"HEIF", "\0\0\0\030ftypheic"s},
                                                           {"PNM", "P5\n4 4\n255\n"s}};
    for (const auto& [name, bytes] : formats) {
        tiny_.write(image(3), bytes);
        EXPECT_THAT(findings(),
                    HasFinding(Severity::Warning, "image_undecodable", "it is " + name));
    }
}

TEST_F(BadRecordingTest, ATrueSurfaceThatIsCutShortIsRefused) {
    const std::string file =
        "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\n"
        "property float x\nproperty float y\nproperty float z\nend_header\nabc";
    tiny_.write("reference.ply", file);
    tiny_.write("scene.ply", file);

    EXPECT_THAT(findings(), HasFinding(Severity::Error, "reference_unreadable", "reference.ply"));
    EXPECT_THAT(findings(), HasFinding(Severity::Error, "reference_unreadable", "scene.ply"));
}

TEST_F(BadRecordingTest, ABrokenDiveJsonIsToldAndLeftOut) {
    tiny_.write("dive.json", std::string(100'000, '['));

    EXPECT_THAT(findings(), HasFinding(Severity::Warning, "json_unreadable", "dive.json"));
}

}  // namespace
}  // namespace divemesh::dive
