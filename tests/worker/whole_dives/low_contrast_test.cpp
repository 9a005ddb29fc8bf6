#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/synthetic/altered_recording.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/dive/dive.hpp"
#include "worker/evaluation/trajectory_error.hpp"
#include "worker/pipeline/reconstruct.hpp"
#include "worker/simulator/simulate.hpp"

namespace divemesh::pipeline {
namespace {

using Look = cv::Mat (*)(const cv::Mat& image);

cv::Mat as_it_is(const cv::Mat& image) { return image; }

// Returns the image with the contrast that distant water leaves.
cv::Mat a_third_of_the_contrast(const cv::Mat& image) {
    cv::Mat result;
    image.convertTo(result, CV_8U, 1.0 / 3.0, 85.0);
    return result;
}

cv::Mat gamma_of_two(const cv::Mat& image) {
    cv::Mat table(1, 256, CV_8U);
    for (int i = 0; i < 256; ++i)
        table.at<std::uint8_t>(i) =
            cv::saturate_cast<std::uint8_t>(255.0 * std::pow(i / 255.0, 2.0));
    cv::Mat result;
    cv::LUT(image, table, result);
    return result;
}

cv::Mat equalised(const cv::Mat& image) {
    cv::Mat result;
    cv::createCLAHE(3.0, cv::Size(8, 8))->apply(image, result);
    return result;
}

class LowContrastTest : public testing::Test {
protected:
    static void SetUpTestSuite() {
        folder_ = std::make_unique<TemporaryFolder>();
        simulator::simulate({.scene = simulator::SceneKind::Barge,
                             .out = *folder_ / "dive",
                             .length_m = 1.5,
                             .water = simulator::WaterKind::Green,
                             .width_px = 320,
                             .height_px = 240});
    }
    static void TearDownTestSuite() { folder_.reset(); }

    struct Swim {
        types::TrackStatistics tracking;
        double ate_m = 0.0;
    };
    Swim swim(Look look, Look equalise) {
        synthetic::AlteredRecording altered(*dive_, [=](types::StereoFrame& frame) {
            for (cv::Mat* image : {&frame.left, &frame.right}) *image = equalise(look(*image));
        });
        const keyframes::KeyframeStore store(*folder_ / "keyframes");
        const auto options = make_options("standard", {{"surface", false}, {"num_threads", 1}});
        const types::Track track = pipeline::track(altered, options, store, base::ignore_progress);
        const types::OptimisedTrack path =
            pipeline::optimise(track, altered, options, store, {}, base::ignore_progress);
        return {track.statistics,
                evaluation::trajectory_error(path.trajectory, dive_->ground_truth()).ate_rmse_m};
    }

    static inline std::unique_ptr<TemporaryFolder> folder_;
    std::unique_ptr<dive::Dive> dive_ = dive::Dive::open(*folder_ / "dive", *folder_ / "scratch");
};

// Patches are compared without their mean brightness, and with a gain and a bias of their own, so
// low contrast needs no correction beforehand. The errors of single swims scatter by a millimetre.
TEST_F(LowContrastTest, TheDiveIsFollowedAsWellAsOverEqualisedImages) {
    double plain_m = 0.0;
    double with_m = 0.0;
    for (const Look look : {a_third_of_the_contrast, gamma_of_two}) {
        const Swim plain = swim(look, as_it_is);
        const Swim with = swim(look, equalised);
        EXPECT_EQ(plain.tracking.num_frames_tracked, plain.tracking.num_frames);
        EXPECT_GE(plain.tracking.median_track_life_frames, with.tracking.median_track_life_frames);
        plain_m += 0.5 * plain.ate_m;
        with_m += 0.5 * with.ate_m;
    }
    EXPECT_LT(plain_m, with_m + 0.001);
}

}  // namespace
}  // namespace divemesh::pipeline
