#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/temporary_folder.hpp"
#include "worker/dive/dive.hpp"
#include "worker/evaluation/trajectory_error.hpp"
#include "worker/pipeline/reconstruct.hpp"
#include "worker/simulator/simulate.hpp"

namespace divemesh::pipeline {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

// The images of a dive with the rig and the IMU of another recording.
class DiveWithImu : public types::Recording {
public:
    DiveWithImu(types::Recording& dive, types::Rig rig, std::vector<types::ImuSample> imu)
        : dive_(dive), rig_(std::move(rig)), imu_(std::move(imu)) {}

    const types::Rig& rig() const override { return rig_; }
    const std::vector<types::ImuSample>& imu() const override { return imu_; }
    const std::vector<types::OrientationSample>& ahrs() const override { return ahrs_; }
    const std::vector<types::PressureSample>& pressure() const override { return pressure_; }
    const cv::Mat& fixed_pattern() const override { return dive_.fixed_pattern(); }
    int num_frames() const override { return dive_.num_frames(); }
    std::optional<types::StereoFrame> frame(int index) const override { return dive_.frame(index); }
    cv::Mat left_in_color(int frame_index, int reduction) const override {
        return dive_.left_in_color(frame_index, reduction);
    }
    void rewind() override { dive_.rewind(); }
    std::int64_t num_skipped_frames() const override { return dive_.num_skipped_frames(); }
    std::optional<types::StereoFrame> next_frame() override { return dive_.next_frame(); }

private:
    types::Recording& dive_;
    types::Rig rig_;
    std::vector<types::ImuSample> imu_;
    std::vector<types::OrientationSample> ahrs_;
    std::vector<types::PressureSample> pressure_;
};

// One dive of twenty seconds whose IMU is made wrong in one way or another.
class WrongImuTest : public testing::Test {
protected:
    struct Swum {
        types::OptimisedTrack track;
        double ate_m = 0.0;

        bool has(const std::string& code) const {
            return std::ranges::any_of(track.findings,
                                       [&](const Finding& of) { return of.code == code; });
        }
    };

    static void SetUpTestSuite() {
        folder_ = std::make_unique<TemporaryFolder>();
        for (const int seed : {1, 2})
            simulator::simulate({.scene = simulator::SceneKind::Tank,
                                 .out = *folder_ / ("dive" + std::to_string(seed)),
                                 .length_m = 5.0,
                                 .rate_hz = 8.0,
                                 .seed = static_cast<std::uint64_t>(seed),
                                 .width_px = 320,
                                 .height_px = 240});
        dive_ = dive::Dive::open(*folder_ / "dive1", *folder_ / "scratch1");
    }
    static void TearDownTestSuite() {
        dive_.reset();
        folder_.reset();
    }

    static Swum swim(const std::vector<types::ImuSample>& imu, const nlohmann::json& more = {}) {
        return swim(dive_->rig(), imu, more);
    }
    static Swum swim(const types::Rig& rig,
                     const std::vector<types::ImuSample>& imu,
                     const nlohmann::json& more = {}) {
        DiveWithImu recording(*dive_, rig, imu);
        recording.rewind();
        nlohmann::json all = more.is_null() ? nlohmann::json::object() : more;
        all["surface"] = false;
        const ReconstructionOptions options = make_options("standard", all);
        const keyframes::KeyframeStore store(*folder_ / "keyframes");
        const types::Track track =
            pipeline::track(recording, options, store, base::ignore_progress);
        Swum swum{pipeline::optimise(track, recording, options, store, {}, base::ignore_progress)};
        swum.ate_m =
            evaluation::trajectory_error(swum.track.trajectory, dive_->ground_truth()).ate_rmse_m;
        return swum;
    }
    // Returns the error without IMU and what a wrong one may add to it.
    static double tolerated_m() {
        return 1.05 * swim(dive_->imu(), {{"use_imu", false}}).ate_m + 0.0005;
    }

    static inline std::unique_ptr<TemporaryFolder> folder_;
    static inline std::unique_ptr<dive::Dive> dive_;
};

TEST_F(WrongImuTest, AClockThatIsLateIsFound) {
    std::vector<types::ImuSample> imu = dive_->imu();
    for (types::ImuSample& sample : imu) sample.timestamp_ns += kSecond_ns / 4;
    const Swum swum = swim(imu);
    EXPECT_TRUE(swum.has("imu_clock_offset"));
    EXPECT_LT(swum.ate_m, tolerated_m());
}

TEST_F(WrongImuTest, AMirroredAxisIsLeftOut) {
    std::vector<types::ImuSample> imu = dive_->imu();
    for (types::ImuSample& sample : imu) {
        sample.angular_velocity_imu.y() *= -1.0;
        sample.acceleration_imu.y() *= -1.0;
    }
    const Swum swum = swim(imu);
    EXPECT_TRUE(swum.has("imu_left_out"));
    EXPECT_LT(swum.ate_m, tolerated_m());
}

TEST_F(WrongImuTest, TheImuOfAnotherDiveIsLeftOut) {
    const auto other = dive::Dive::open(*folder_ / "dive2", *folder_ / "scratch2");
    std::vector<types::ImuSample> imu = other->imu();
    const std::int64_t later_ns = dive_->imu().front().timestamp_ns - imu.front().timestamp_ns;
    for (types::ImuSample& sample : imu) sample.timestamp_ns += later_ns;
    const Swum swum = swim(imu);
    EXPECT_TRUE(swum.has("imu_left_out"));
    EXPECT_LT(swum.ate_m, tolerated_m());
}

// Returns the samples with rows of zeros for four seconds.
std::vector<types::ImuSample> with_zeros(std::vector<types::ImuSample> imu, double from_s) {
    const std::int64_t from_ns =
        imu.front().timestamp_ns +
        static_cast<std::int64_t>(from_s * static_cast<double>(kSecond_ns));
    for (types::ImuSample& sample : imu) {
        if (sample.timestamp_ns < from_ns || sample.timestamp_ns > from_ns + 4 * kSecond_ns)
            continue;
        sample.angular_velocity_imu.setZero();
        sample.acceleration_imu.setZero();
    }
    return imu;
}

TEST_F(WrongImuTest, RowsOfZerosForATimeAreLeftOut) {
    const double limit_m = tolerated_m();
    for (const double from_s : {4.4, 6.0, 8.6, 10.7, 13.5})
        EXPECT_LT(swim(with_zeros(dive_->imu(), from_s)).ate_m, limit_m) << from_s;
}

TEST_F(WrongImuTest, AClockThatJumpsIsLeftOutFromThenOn) {
    std::vector<types::ImuSample> imu = dive_->imu();
    const std::int64_t jump_ns = imu.front().timestamp_ns + 8 * kSecond_ns;
    for (types::ImuSample& sample : imu)
        if (sample.timestamp_ns >= jump_ns) sample.timestamp_ns += kSecond_ns / 5;
    const Swum swum = swim(imu);
    EXPECT_TRUE(swum.has("imu_left_out_for_a_time"));
    EXPECT_LT(swum.ate_m, tolerated_m());
}

// The path of the rendered IMU is the truth; the calibration states another place for it.
TEST_F(WrongImuTest, AnImuElsewhereInTheRigIsFound) {
    const Eigen::Vector3d moved_m(0.12, -0.15, 0.1);
    types::Rig rig = dive_->rig();
    for (Eigen::Isometry3d* T_imu_cam : {&rig.T_imu_cam0, &rig.T_imu_cam1})
        T_imu_cam->pretranslate(moved_m);
    const Swum swum = swim(rig, dive_->imu());
    const types::RefinedCalibration& calibration = swum.track.calibration;
    EXPECT_TRUE(calibration.lever_arm_applied);
    EXPECT_LT((calibration.lever_arm_m - moved_m).norm(), 0.05);
    const Swum as_stated = swim(rig, dive_->imu(), {{"align_imu", false}});
    EXPECT_LT(swum.ate_m, 0.5 * as_stated.ate_m);
}

}  // namespace
}  // namespace divemesh::pipeline
