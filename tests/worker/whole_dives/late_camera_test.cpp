#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/synthetic/altered_recording.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/dive/dive.hpp"
#include "worker/evaluation/trajectory_error.hpp"
#include "worker/pipeline/aligned_recording.hpp"
#include "worker/pipeline/reconstruct.hpp"
#include "worker/simulator/simulate.hpp"

namespace divemesh::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr double kDelay_s = 0.012;

// A dive whose right camera does not fire with the left one.
class LateCameraTest : public testing::Test {
protected:
    void simulate(simulator::SimulateOptions options) {
        options.scene = simulator::SceneKind::Barge;
        options.out = folder_ / "dive";
        options.seed = 3;
        options.width_px = 320;
        options.height_px = 240;
        simulator::simulate(options);
    }

    void open() { dive_ = dive::Dive::open(folder_ / "dive", folder_ / "scratch"); }

    double absolute_error_m(const synthetic::AlteredRecording::Alter& alter) {
        synthetic::AlteredRecording altered(*dive_, alter);
        AlignedRecording recording(altered);
        recording.rewind();
        const keyframes::KeyframeStore store(folder_ / "keyframes");
        const auto options = make_options("standard", {{"surface", false}, {"num_threads", 1}});
        const types::Track track =
            pipeline::track(recording, options, store, base::ignore_progress);
        EXPECT_EQ(track.sigmas.size(), track.odometry.size());
        const types::OptimisedTrack path =
            pipeline::optimise(track, recording, options, store, {}, base::ignore_progress);
        return evaluation::trajectory_error(path.trajectory, dive_->ground_truth()).ate_rmse_m;
    }
    double compensated_error_m() {
        return absolute_error_m([](types::StereoFrame&) {});
    }
    double uncompensated_error_m() {
        return absolute_error_m([](types::StereoFrame& frame) { frame.right_delay_s = 0.0; });
    }

    TemporaryFolder folder_;
    std::unique_ptr<dive::Dive> dive_;
};

TEST_F(LateCameraTest, TheMotionBetweenTheExposuresIsTakenOff) {
    simulate({.length_m = 3.0, .stereo_offset_ms = 1e3 * kDelay_s});  // its stamps do not say so
    open();

    EXPECT_NEAR(dive_->frame(0).value().right_delay_s, kDelay_s, 0.003);
    const double compensated_m = compensated_error_m();
    EXPECT_LT(compensated_m, 0.005);
    EXPECT_LT(compensated_m, 0.5 * uncompensated_error_m());
}

// Keeps every third left image, and a right image that is up to one image earlier or later: pairs
// at a third of the rate, with true stamps that differ by up to a third of a period.
class UnevenCameraTest : public LateCameraTest {
protected:
    static constexpr double kRate_hz = 30.0;
    // Returns by how many images the right one of a pair is later.
    static int images_later(int index) {
        constexpr std::array<int, 5> kPattern = {-1, 1, 0, 1, -1};
        return kPattern[static_cast<std::size_t>(index % 5)];
    }

    static std::vector<std::string> lines_of(const fs::path& file) {
        std::vector<std::string> lines;
        std::ifstream stream(file);
        for (std::string line; std::getline(stream, line);)
            if (!line.starts_with('#')) lines.push_back(line);
        return lines;
    }
    void keep_uneven_pairs() const {
        const fs::path left = folder_ / "dive/mav0/cam0/data.csv";
        const fs::path right = folder_ / "dive/mav0/cam1/data.csv";
        const auto left_lines = lines_of(left);
        const auto right_lines = lines_of(right);
        std::ofstream kept_left(left);
        std::ofstream kept_right(right);
        for (int i = 0; 3 * i + 2 < std::ssize(left_lines); ++i) {
            const int left_image = 3 * i + 1;
            const int right_image = left_image + images_later(i);
            kept_left << left_lines[static_cast<std::size_t>(left_image)] << '\n';
            kept_right << right_lines[static_cast<std::size_t>(right_image)] << '\n';
        }
    }
};

TEST_F(UnevenCameraTest, TheMotionDuringTheGapOfEachPairIsTakenOff) {
    simulate({.length_m = 2.0, .rate_hz = kRate_hz});
    keep_uneven_pairs();
    open();

    for (int i = 0; i < dive_->num_frames(); i += 7)
        EXPECT_NEAR(dive_->frame(i).value().right_delay_s, images_later(i) / kRate_hz, 0.003) << i;
    const double compensated_m = compensated_error_m();
    EXPECT_LT(compensated_m, 0.01);
    EXPECT_LT(compensated_m, 0.5 * uncompensated_error_m());
}

}  // namespace
}  // namespace divemesh::pipeline
