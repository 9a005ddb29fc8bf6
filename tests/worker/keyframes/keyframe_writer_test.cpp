#include "worker/keyframes/keyframe_writer.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgproc.hpp>

#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::keyframes {
namespace {

// Returns a frame of a wall with noise as texture, at a disparity of 12 px.
types::RectifiedFrame wall(int index) {
    types::RectifiedFrame frame;
    frame.index = index;
    cv::Mat wide(120, 200, CV_8U);
    cv::RNG random(7);
    random.fill(wide, cv::RNG::UNIFORM, 0, 255);
    cv::GaussianBlur(wide, wide, {3, 3}, 0.8);
    frame.left = wide(cv::Rect(0, 0, 160, 120)).clone();
    frame.right = wide(cv::Rect(12, 0, 160, 120)).clone();
    return frame;
}

features::DescribedKeypoints view_of(int num_points) {
    features::DescribedKeypoints view(static_cast<std::size_t>(num_points));
    for (int i = 0; i < num_points; ++i) {
        view[static_cast<std::size_t>(i)].u_px = static_cast<float>(i);
        view[static_cast<std::size_t>(i)].descriptor.fill(0x9E3779B97F4A7C15ULL >> i);
    }
    return view;
}

TEST(KeyframeWriter, MatchesWhatTheCallerHasNotMatched) {
    const TemporaryFolder folder;
    const KeyframeStore store(folder.path());
    base::TaskPool task_pool(2);
    KeyframeWriter writer(ReconstructionOptions{}, store, task_pool);
    for (int i = 0; i < 5; ++i) {
        KeyframeWriter::Seen seen;
        if (i % 2 == 0) seen.view = view_of(i);
        writer.write(wall(i), {}, seen);
    }
    writer.finish();
    for (int i = 0; i < 5; ++i)
        EXPECT_NEAR(store.read(i).depth.disparity_px.at<float>(60, 100), 12.0F, 0.1F);
    EXPECT_LT(cv::norm(store.read_left(2), wall(2).left, cv::NORM_INF), 20.0);
    const features::DescribedKeypoints view = store.read_keypoints(4);
    ASSERT_EQ(view.size(), 4U);
    EXPECT_EQ(view[3].u_px, 3.0F);
    EXPECT_EQ(view[3].descriptor, view_of(4)[3].descriptor);
    EXPECT_TRUE(store.read_keypoints(0).empty());
    EXPECT_THROW(store.read_left(1), Error);  // not a keyframe
    EXPECT_THROW(store.read_keypoints(1), Error);
}

TEST(KeyframeWriter, KeepsWhatTheCallerHasMatched) {
    const TemporaryFolder folder;
    const KeyframeStore store(folder.path());
    base::TaskPool task_pool(2);
    KeyframeWriter writer(ReconstructionOptions{}, store, task_pool);
    types::DepthMap depth;
    depth.disparity_px = cv::Mat(120, 160, CV_32F, cv::Scalar(30.0));
    depth.sigma_disparity_px = cv::Mat(120, 160, CV_32F, cv::Scalar(0.25));
    writer.write(wall(3), depth, {});
    writer.finish();
    EXPECT_NEAR(store.read(3).depth.disparity_px.at<float>(60, 100), 30.0F, 0.01F);
}

TEST(KeyframeWriter, WithoutASurfaceKeepsTheGreyImageAlone) {
    const TemporaryFolder folder;
    const KeyframeStore store(folder.path());
    base::TaskPool task_pool(2);
    ReconstructionOptions options;
    options.surface = false;
    KeyframeWriter writer(options, store, task_pool);
    writer.write(wall(0), {}, {view_of(2), {}, {}, {}});
    writer.finish();
    EXPECT_EQ(store.read_left(0).size(), cv::Size(160, 120));
    EXPECT_THROW(store.read(0), Error);
}

TEST(KeyframeWriter, ADiskThatTakesNothingIsToldAtTheEndAtTheLatest) {
    const TemporaryFolder folder;
    const auto gone = folder / "keyframes";
    const KeyframeStore store(gone);
    std::filesystem::remove(gone);
    base::TaskPool task_pool(2);
    KeyframeWriter writer(ReconstructionOptions{}, store, task_pool);
    writer.write(wall(0), {}, {view_of(2), {}, {}, {}});
    EXPECT_THROW(writer.finish(), Error);
}

}  // namespace
}  // namespace divemesh::keyframes
