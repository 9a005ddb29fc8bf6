#include "worker/keyframes/keyframe_store.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "schemas/error.hpp"
#include "tests/synthetic/ideal_rig.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::keyframes {
namespace {

types::DepthMap slope() {
    types::DepthMap depth;
    depth.disparity_px = cv::Mat(48, 64, CV_32F);
    depth.sigma_disparity_px = cv::Mat(48, 64, CV_32F, cv::Scalar(0.25));
    for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 64; ++x)
            depth.disparity_px.at<float>(y, x) =
                x < 8 ? 0.0F : 20.0F + 0.3F * static_cast<float>(x);
    return depth;
}

cv::Mat image_of(int frame_index) { return {48, 64, CV_8UC3, cv::Scalar(10, 20, frame_index)}; }

TEST(KeyframeStore, KeepsDisparityToAnEighthOfTheStereoNoise) {
    const TemporaryFolder folder;
    const KeyframeStore store(folder / "keyframes");
    const types::DepthMap written = slope();
    store.write(7, written);
    const types::DepthMap read = store.read(7).depth;

    EXPECT_LE(cv::norm(read.disparity_px, written.disparity_px, cv::NORM_INF), 0.5 / 128.0);
    EXPECT_LE(cv::norm(read.sigma_disparity_px, written.sigma_disparity_px, cv::NORM_INF),
              0.5 / 64.0);
}

// Half the size of a wide image finds disparities beyond 512 px.
TEST(KeyframeStore, KeepsSurfaceNearerThanTheFullSizeSearches) {
    const TemporaryFolder folder;
    const KeyframeStore store(folder / "keyframes");
    types::DepthMap written = slope();
    written.disparity_px(cv::Rect(20, 8, 16, 16)).setTo(611.3);
    written.disparity_px(cv::Rect(40, 8, 16, 16)).setTo(767.9);
    store.write(7, written);
    const cv::Mat read = store.read(7).depth.disparity_px;

    EXPECT_LE(cv::norm(read, written.disparity_px, cv::NORM_INF), 0.5 / 64.0);
    EXPECT_EQ(store.read_disparities(7, 8).at<float>(1, 3), read.at<float>(8, 24));
    EXPECT_EQ(read.at<float>(10, 3), 0.0F) << "unknown";
}

TEST(KeyframeStore, TheImageIsThatOfTheRecording) {
    const TemporaryFolder folder;
    const KeyframeStore store(folder.path(), image_of);
    store.write(7, slope());
    EXPECT_EQ(cv::norm(store.read(7).left_color, image_of(7), cv::NORM_INF), 0.0);
    EXPECT_EQ(cv::norm(store.left_in_color(9), image_of(9), cv::NORM_INF), 0.0);
}

TEST(KeyframeStore, CorrectedItReadsWhatAGlobalShutterSees) {
    const TemporaryFolder folder;
    const KeyframeStore store(folder.path(), image_of);
    store.write(7, slope());
    store.write(8, slope());
    const types::RectifiedRig rig = synthetic::ideal_rig(64, 48, 50.0);
    const auto correction = std::make_shared<camera::ShutterCorrection>(
        rig,
        camera::rectified_lenses(synthetic::ideal_cameras(rig))[0],
        0.05,
        std::map<int, camera::CameraMotion>{{7, {{0.0, 0.0, 0.0}, {2.0, 0.0, 0.0}}}});
    const KeyframeStore corrected = store.corrected(correction);
    const auto difference = [&](int frame, const cv::Mat& expected) {
        return cv::norm(corrected.read(frame).depth.disparity_px, expected, cv::NORM_INF);
    };
    EXPECT_EQ(difference(7, correction->moved(7, store.read(7)).depth.disparity_px), 0.0);
    EXPECT_GT(difference(7, store.read(7).depth.disparity_px), 0.1);
    EXPECT_EQ(difference(8, store.read(8).depth.disparity_px), 0.0);  // its motion is not known
    EXPECT_EQ(cv::norm(corrected.left_in_color(7), corrected.read(7).left_color, cv::NORM_INF),
              0.0);
    EXPECT_THROW(corrected.left_in_color(9), Error);
}

TEST(KeyframeStore, AtItsOwnRangeEveryPixelMovesByTheTable) {
    const TemporaryFolder folder;
    const KeyframeStore store(folder.path(), image_of);
    store.write(7, slope());
    const auto two_to_the_right = std::make_shared<types::RangeTable>(
        types::RangeTable{2, 2, 2, 63.0, 47.0, 20.0, {8, Eigen::Vector3f(2.0F, 0.0F, 5.0F)}});
    const types::KeyframeImages before = store.read(7);

    const types::KeyframeImages moved = store.at_own_range(two_to_the_right).read(7);

    const cv::Rect from(20, 5, 30, 30);
    const cv::Rect to = from + cv::Point(2, 0);
    EXPECT_LT(cv::norm(moved.depth.disparity_px(to), before.depth.disparity_px(from), cv::NORM_INF),
              1e-4);
    EXPECT_LE(cv::norm(moved.left_color(to), before.left_color(from), cv::NORM_INF), 1.0);
    EXPECT_EQ(
        cv::norm(
            store.at_own_range(two_to_the_right).left_in_color(7), moved.left_color, cv::NORM_INF),
        0.0);
}

TEST(KeyframeStore, TheDepthAloneIsReadWithoutTheImage) {
    const TemporaryFolder folder;
    const types::RectifiedRig rig = synthetic::ideal_rig(64, 48, 50.0);
    types::LensChange change;
    change.values[1] = 1.5;  // of the principal point, px
    const auto rerectifier = std::make_shared<camera::KeyframeRerectifier>(
        rig, camera::Rerectifier(synthetic::ideal_cameras(rig), rig, {change, {}}));
    const KeyframeStore store = KeyframeStore(folder.path(), image_of).rerectified(rerectifier);
    store.write(7, slope());
    const KeyframeStore without_images = KeyframeStore(folder.path(), [](int) -> cv::Mat {
                                             throw Error(ErrorCode::NotFound, "the image was read");
                                         }).rerectified(rerectifier);
    const types::DepthMap depth = without_images.read_depth(7);
    const types::DepthMap whole = store.read(7).depth;
    EXPECT_EQ(cv::norm(depth.disparity_px, whole.disparity_px, cv::NORM_INF), 0.0);
    EXPECT_EQ(cv::norm(depth.sigma_disparity_px, whole.sigma_disparity_px, cv::NORM_INF), 0.0);
    EXPECT_GT(cv::norm(depth.disparity_px, slope().disparity_px, cv::NORM_INF), 0.5);
}

TEST(KeyframeStore, UnknownDisparityStaysUnknown) {
    const TemporaryFolder folder;
    const KeyframeStore store(folder.path());
    store.write(0, slope());
    EXPECT_EQ(store.read(0).depth.disparity_px.at<float>(10, 3), 0.0F);
}

TEST(KeyframeStore, EverySoManiethDisparityIsThatOfTheWhole) {
    const TemporaryFolder folder;
    const KeyframeStore store(folder.path());
    store.write(3, slope());
    const cv::Mat whole = store.read(3).depth.disparity_px;
    for (const int step_px : {1, 5, 8}) {
        const cv::Mat some = store.read_disparities(3, step_px);
        ASSERT_EQ(some.size(),
                  cv::Size((64 + step_px - 1) / step_px, (48 + step_px - 1) / step_px));
        for (int y = 0; y < some.rows; ++y)
            for (int x = 0; x < some.cols; ++x)
                EXPECT_EQ(some.at<float>(y, x), whole.at<float>(y * step_px, x * step_px));
    }
    std::filesystem::resize_file(folder / "00000003.keyframe", 1000);
    EXPECT_THROW(store.read_disparities(3, 8), Error);
    EXPECT_THROW(store.read_disparities(4, 8), Error);
}

TEST(KeyframeStore, AMissingOrShortenedFileIsATypedError) {
    const TemporaryFolder folder;
    const KeyframeStore store(folder.path());
    EXPECT_THROW(store.read(1), Error);
    store.write(1, slope());
    for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
        std::filesystem::resize_file(entry.path(), entry.file_size() - 1);
    EXPECT_THROW(store.read(1), Error);
}

}  // namespace
}  // namespace divemesh::keyframes
