#include "tests/bench/dive_change.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <tuple>

#include "tests/bench/frame_overlap.hpp"
#include "tests/bench/images.hpp"
#include "tests/bench/small_dive.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/dive/dive.hpp"

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;

class DiveChangeTest : public testing::Test {
protected:
    static void SetUpTestSuite() {
        folder_ = std::make_unique<TemporaryFolder>();
        render_small_dive(*folder_ / "dive");
        plain_ = opened(*folder_ / "dive");
    }
    static void TearDownTestSuite() {
        plain_.reset();
        folder_.reset();
    }

    static std::unique_ptr<dive::Dive> opened(const fs::path& dive) {
        return dive::Dive::open(dive, *folder_ / "scratch");
    }
    static fs::path write(const DiveChange& change) {
        const fs::path out = *folder_ / ("changed" + std::to_string(++num_changed_));
        const fs::path dive = *folder_ / "dive";
        write_changed({.dive = dive, .other = dive, .blue = dive}, change, 7, out);
        return out;
    }
    static std::unique_ptr<dive::Dive> changed(const DiveChange& change) {
        return opened(write(change));
    }

    static inline std::unique_ptr<TemporaryFolder> folder_;
    static inline std::unique_ptr<dive::Dive> plain_;
    static inline int num_changed_ = 0;
};

TEST_F(DiveChangeTest, WithoutAChangeRigImuAndTruthStayAndKnownLengthsGo) {
    const auto dive = changed({});
    EXPECT_EQ(dive->num_frames(), plain_->num_frames());
    EXPECT_EQ(dive->imu().size(), plain_->imu().size());
    EXPECT_EQ(dive->ground_truth().size(), plain_->ground_truth().size());
    EXPECT_TRUE(dive->rig().T_imu_cam1.isApprox(plain_->rig().T_imu_cam1, 1e-9));
    EXPECT_TRUE(dive->known_distances().empty());
    EXPECT_TRUE(dive->ahrs().empty());
}

TEST_F(DiveChangeTest, FramesAreKeptDroppedAndCutAsAsked) {
    const int num_frames = plain_->num_frames();
    EXPECT_EQ(changed({.keep_every = 3})->num_frames(), (num_frames + 2) / 3);
    const int num_left = changed({.dropped_share = 0.5})->num_frames();
    EXPECT_GT(num_left, 0.2 * num_frames);
    EXPECT_LT(num_left, 0.8 * num_frames);
    const auto cut = changed({.gap_s = 2.0});
    std::int64_t longest_ns = 0;
    auto before = cut->next_frame();
    while (const auto now = cut->next_frame()) {
        longest_ns = std::max(longest_ns, now->timestamp_ns - before->timestamp_ns);
        before->timestamp_ns = now->timestamp_ns;
    }
    EXPECT_NEAR(1e-9 * static_cast<double>(longest_ns), 2.0, 0.3);
}

TEST_F(DiveChangeTest, DoubledFrameShowsTheImageBeforeIt) {
    const PairFiles pairs = pair_files(write({.doubled_share = 0.5}));
    int num_doubled = 0;
    for (std::size_t i = 1; i < pairs.size(); ++i)
        if (fs::equivalent(pairs[i].first, pairs[i - 1].first)) {
            EXPECT_TRUE(fs::equivalent(pairs[i].second, pairs[i - 1].second));
            ++num_doubled;
        }
    EXPECT_EQ(static_cast<int>(pairs.size()), plain_->num_frames());
    EXPECT_GT(num_doubled, plain_->num_frames() / 5);
}

TEST_F(DiveChangeTest, BlueStretchShowsTheImagesOfTheBlueDive) {
    const fs::path dive = *folder_ / "dive";
    const fs::path blue = *folder_ / "blue";
    fs::copy(dive, blue, fs::copy_options::recursive);
    const fs::path out = *folder_ / "with_blue";
    write_changed(
        {.dive = dive, .other = {}, .blue = blue}, {.blue_at_share = 0.5, .blue_s = 1.0}, 7, out);
    const PairFiles shown = pair_files(out);
    const PairFiles blue_pairs = pair_files(blue);
    std::vector<std::size_t> replaced;
    for (std::size_t i = 0; i < shown.size(); ++i)
        if (fs::equivalent(shown[i].first, blue_pairs[i].first)) replaced.push_back(i);
    ASSERT_EQ(replaced.size(), 4U);  // a second at four pairs a second
    EXPECT_EQ(replaced.back() - replaced.front(), 3U);
    EXPECT_NEAR(
        static_cast<double>(replaced.front()), 0.5 * static_cast<double>(shown.size() - 1), 1.0);
}

TEST_F(DiveChangeTest, KeptFramesOverlapByWhatWasAsked) {
    const FrameOverlap overlap(*folder_ / "dive");
    EXPECT_NEAR(overlap.between(2, 2), 1.0, 1e-9);
    EXPECT_GT(overlap.between(0, 1), overlap.between(0, 4));
    const auto frames = overlap.spaced_by(0.6);
    ASSERT_GE(frames.size(), 3U);
    for (std::size_t i = 1; i < frames.size(); ++i) {
        EXPECT_GE(overlap.between(frames[i - 1], frames[i]), 0.6);
        EXPECT_LT(overlap.between(frames[i - 1], frames[i] + 1), 0.6);
    }
}

TEST_F(DiveChangeTest, LyingImusLieAsNamed) {
    using Imu = DiveChange::Imu;
    EXPECT_TRUE(changed({.imu = Imu::None})->imu().empty());
    const auto& exact = plain_->imu();
    const auto late = changed({.imu = Imu::Late});
    EXPECT_EQ(late->imu()[9].timestamp_ns - exact[9].timestamp_ns, 250'000'000);
    EXPECT_TRUE(late->imu()[9].acceleration_imu.isApprox(exact[9].acceleration_imu, 1e-9));
    const auto mirrored = changed({.imu = Imu::Mirrored});
    EXPECT_NEAR(
        mirrored->imu()[9].angular_velocity_imu.y(), -exact[9].angular_velocity_imu.y(), 1e-9);
    EXPECT_NEAR(
        mirrored->imu()[9].angular_velocity_imu.x(), exact[9].angular_velocity_imu.x(), 1e-9);
    const double stated = plain_->rig().imu_noise->gyroscope_noise_density;
    EXPECT_NEAR(changed({.imu = Imu::NoiseTooSmall})->rig().imu_noise->gyroscope_noise_density,
                0.01 * stated,
                1e-3 * stated);
}

TEST_F(DiveChangeTest, ImusThatFailDoSoFromTwoFifthsOn) {
    using Imu = DiveChange::Imu;
    const auto& exact = plain_->imu();
    const std::size_t before = exact.size() / 5;
    const std::size_t after = exact.size() - 2;
    const auto difference = [&](Imu kind, std::size_t i) {
        const types::ImuSample sample = changed({.imu = kind})->imu().at(i);
        return std::tuple{(sample.angular_velocity_imu - exact[i].angular_velocity_imu).norm(),
                          (sample.acceleration_imu - exact[i].acceleration_imu).norm(),
                          static_cast<double>(sample.timestamp_ns - exact[i].timestamp_ns)};
    };
    for (const Imu kind :
         {Imu::GyroscopeStops, Imu::ForcesDouble, Imu::BiasJumps, Imu::ClockJumps}) {
        const auto [rate, force, time] = difference(kind, before);
        EXPECT_LT(rate + force + time, 1e-6);
    }
    EXPECT_NEAR(std::get<0>(difference(Imu::BiasJumps, after)), 0.06, 1e-6);
    EXPECT_NEAR(std::get<2>(difference(Imu::ClockJumps, after)), 2e8, 1.0);
    const std::size_t within = exact.size() * 9 / 20;
    EXPECT_NEAR(std::get<1>(difference(Imu::ForcesDouble, within)),
                exact[within].acceleration_imu.norm(),
                1e-6);
    EXPECT_NEAR(std::get<0>(difference(Imu::GyroscopeStops, within)),
                exact[within].angular_velocity_imu.norm(),
                1e-3);
}

TEST_F(DiveChangeTest, MemsImuHasTheNoiseThatItStates) {
    const auto mems = changed({.imu = DiveChange::Imu::Mems});
    const auto& exact = plain_->imu();
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    double squared = 0.0;
    for (std::size_t i = 0; i < exact.size(); ++i) {
        const Eigen::Vector3d error =
            mems->imu()[i].angular_velocity_imu - exact[i].angular_velocity_imu;
        mean += error / static_cast<double>(exact.size());
        squared += error.squaredNorm() / static_cast<double>(exact.size());
    }
    const double sigma = std::sqrt((squared - mean.squaredNorm()) / 3.0);
    const double stated = mems->rig().imu_noise->gyroscope_noise_density;
    EXPECT_NEAR(sigma / (stated * std::sqrt(200.0)), 1.0, 0.05);
}

TEST_F(DiveChangeTest, CalibrationIsWrongAndImagesStay) {
    const auto wrong = changed({.calibration_error = 1.0});
    EXPECT_FALSE(wrong->rig().T_imu_cam1.isApprox(plain_->rig().T_imu_cam1, 1e-6));
    EXPECT_NE(wrong->imu()[0].timestamp_ns, plain_->imu()[0].timestamp_ns);
    EXPECT_TRUE(fs::equivalent(pair_files(write({.calibration_error = 1.0}))[0].second,
                               pair_files(*folder_ / "dive")[0].second));
}

TEST_F(DiveChangeTest, RightImageIsDarkerByTheExposureThroughTheToneCurve) {
    const PairFiles dark = pair_files(write({.right_exposure = 0.5}));
    const PairFiles plain = pair_files(*folder_ / "dive");
    const auto brightness = [](const fs::path& file) {
        return cv::mean(cv::imread(file.string()))[1];
    };
    EXPECT_NEAR(
        brightness(dark[0].second) / brightness(plain[0].second), std::pow(0.5, 1.0 / 2.2), 0.02);
    EXPECT_EQ(brightness(dark[0].first), brightness(plain[0].first));
}

}  // namespace
}  // namespace divemesh::bench
