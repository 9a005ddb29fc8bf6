#include "sensor/preview/dive_assessment.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <opencv2/core.hpp>
#include <sstream>

#include "sensor/recording/recording_source.hpp"
#include "tests/paths.hpp"
#include "tests/sensor/growing_dive.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::sensor {
namespace {

struct Looked {
    nlohmann::json report;
    double distance_m = 0.0;  // that was swum in truth between the first assessment and the last
    double drift_m = 0.0;     // by which the end of the track is off
    double share_of_core = 0.0;
};

// The body in the world, by the time.
std::map<std::int64_t, Eigen::Isometry3d> read_truth(const std::filesystem::path& dive) {
    std::map<std::int64_t, Eigen::Isometry3d> truth;
    std::ifstream stream(dive / "mav0" / "state_groundtruth_estimate0" / "data.csv");
    for (std::string line; std::getline(stream, line);) {
        if (line.starts_with('#')) continue;
        std::replace(line.begin(), line.end(), ',', ' ');
        std::istringstream fields(line);
        std::int64_t stamp = 0;
        Eigen::Vector3d p;
        Eigen::Quaterniond q;
        fields >> stamp >> p.x() >> p.y() >> p.z() >> q.w() >> q.x() >> q.y() >> q.z();
        truth[stamp] = Eigen::Translation3d(p) * q.normalized();
    }
    return truth;
}

// From a second of a dive on, a pair each half second.
Looked look_at(const std::string& dive, double begin_s, double seconds) {
    const auto truth = read_truth(shared_data(dive));
    const auto source = replay_dive(shared_data(dive), 1.0);
    DiveAssessment assessment(source->dive_root());
    ImageCheck quality;
    const auto begin = Clock::now();
    const auto cpu = std::clock();
    std::int64_t first_ns = 0;
    std::int64_t last_ns = 0;
    source->update(begin);
    for (double time_s = begin_s; time_s <= begin_s + seconds; time_s += 0.5) {
        source->update(begin + std::chrono::duration_cast<Clock::duration>(
                                   std::chrono::duration<double>(time_s)));
        const auto now = source->newest_frame();
        const auto before = now ? source->newest_frame(now->timestamp_ns) : now;
        if (!before) continue;
        const int num_lost = assessment.odometry() ? assessment.odometry()->num_lost() : 0;
        assessment.add(*before, *now, quality.check(now->left, now->timestamp_ns));
        if (assessment.odometry()->num_lost() > num_lost) continue;  // the track waits where it was
        if (first_ns == 0) first_ns = now->timestamp_ns;
        last_ns = now->timestamp_ns;
    }
    Looked looked;
    looked.share_of_core = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC / seconds;
    looked.report = assessment.report();
    Eigen::Vector3d p = truth.lower_bound(first_ns)->second.translation();
    for (auto at = truth.lower_bound(first_ns); at != truth.upper_bound(last_ns); ++at) {
        looked.distance_m += (at->second.translation() - p).norm();
        p = at->second.translation();
    }
    const Eigen::Isometry3d T_imu_cam = assessment.odometry()->rig().T_imu_cam;
    const Eigen::Isometry3d T_first_last =
        (truth.lower_bound(first_ns)->second * T_imu_cam).inverse() *
        truth.lower_bound(last_ns)->second * T_imu_cam;
    looked.drift_m =
        (T_first_last.translation() - assessment.odometry()->T_first_current().translation())
            .norm();
    std::cout << dive << " from " << begin_s << " s: " << looked.report.dump() << ", in truth "
              << looked.distance_m << " m, drift " << looked.drift_m << " m; "
              << 100.0 * looked.share_of_core << " % of a core\n";
    return looked;
}

// Returns the RMS error of the track in standard deviations that it states, over parts of a dive.
double surprise(const std::string& dive, double seconds, int num_parts) {
    double sum = 0.0;
    for (int i = 0; i < num_parts; ++i) {
        const Looked looked = look_at(dive, i * seconds, seconds);
        const double off = looked.drift_m / looked.report["expected_drift_m"].get<double>();
        sum += off * off;
    }
    return std::sqrt(sum / num_parts);
}

class DiveAssessmentTest : public testing::TestWithParam<std::string> {};

TEST_P(DiveAssessmentTest, KnowsHowFarWasSwum) {
    const std::string dive = GetParam();
    if (!std::filesystem::exists(shared_data(dive))) GTEST_SKIP() << dive << " is not there";
    const Looked looked = look_at(dive, 0.0, dive == "tank" ? 14.0 : 69.0);
    const double distance_m = looked.report["distance_m"].get<double>();
    EXPECT_NEAR(distance_m, looked.distance_m, 0.05 * looked.distance_m);
    EXPECT_LT(looked.report["lost"].get<double>(), 0.1 * looked.report["pairs"].get<double>());
    EXPECT_GT(looked.report["coverage"].get<double>(), 0.2);
    // Three standard deviations, and no claim that says nothing.
    EXPECT_LT(looked.drift_m, 3.0 * looked.report["expected_drift_m"].get<double>());
    EXPECT_LT(looked.report["expected_drift_m"].get<double>(), 0.1 * looked.distance_m);
}

TEST_P(DiveAssessmentTest, SaysHowFarOffItIs) {
    const std::string dive = GetParam();
    if (!std::filesystem::exists(shared_data(dive))) GTEST_SKIP() << dive << " is not there";
    const double off = surprise(dive, dive == "tank" ? 4.5 : 10.0, dive == "tank" ? 3 : 7);
    EXPECT_GT(off, 0.2);
    EXPECT_LT(off, 2.0);
}

INSTANTIATE_TEST_SUITE_P(Dives,
                         DiveAssessmentTest,
                         testing::Values("tank", "barge"),
                         [](const auto& dive) { return dive.param; });

TEST(DiveAssessmentOfImagesTest, CountsFeaturesWithoutACalibration) {
    const TemporaryFolder folder;
    GrowingDive dive(folder.path());
    dive.add_frame();
    DiveTail tail(folder.path());
    tail.update(std::numeric_limits<std::int64_t>::max());
    DiveAssessment assessment(tail.root());
    EXPECT_TRUE(assessment.report().is_null());
    const auto frame = tail.newest_frame();
    assessment.add(*frame, *frame, ImageCheck().check(frame->left, frame->timestamp_ns));
    EXPECT_GT(assessment.report()["features"].get<int>(), 5);
    EXPECT_FALSE(assessment.report().contains("distance_m"));
}

}  // namespace
}  // namespace divemesh::sensor
