#include "worker/keyframe_store.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgproc.hpp>

#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::worker {
namespace {

KeyframeImages gradient_images() {
    KeyframeImages images;
    images.left_color = cv::Mat(48, 64, CV_8UC3);
    images.depth.disparity_px = cv::Mat(48, 64, CV_32F);
    images.depth.sigma_disparity_px = cv::Mat(48, 64, CV_32F, cv::Scalar(0.25));
    for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 64; ++x) {
            images.left_color.at<cv::Vec3b>(y, x) = cv::Vec3b(
                static_cast<unsigned char>(2 * x), static_cast<unsigned char>(3 * y), 100);
            images.depth.disparity_px.at<float>(y, x) =
                x < 8 ? 0.0F : 20.0F + 0.3F * static_cast<float>(x);
        }
    return images;
}

TEST(KeyframeStore, KeepsDisparityToAnEighthOfTheStereoNoise) {
    const TemporaryFolder folder;
    const KeyframeStore store(folder / "keyframes");
    const auto written = gradient_images();
    store.write(7, written);
    const auto read = store.read(7);

    EXPECT_LE(cv::norm(read.depth.disparity_px, written.depth.disparity_px, cv::NORM_INF),
              0.5 / 128.0);
    EXPECT_LE(
        cv::norm(read.depth.sigma_disparity_px, written.depth.sigma_disparity_px, cv::NORM_INF),
        0.5 / 64.0);
    EXPECT_LT(cv::norm(read.left_color, written.left_color, cv::NORM_L1) / (48.0 * 64.0 * 3.0),
              2.0);
}

TEST(KeyframeStore, UnknownDisparityStaysUnknown) {
    const TemporaryFolder folder;
    const KeyframeStore store(folder.path());
    store.write(0, gradient_images());
    EXPECT_EQ(store.read(0).depth.disparity_px.at<float>(10, 3), 0.0F);
}

TEST(KeyframeStore, APictureWithoutDepthStaysWithout) {
    const TemporaryFolder folder;
    const KeyframeStore store(folder.path());
    store.write(0, {gradient_images().left_color, {}});
    const auto read = store.read(0);
    EXPECT_TRUE(read.depth.disparity_px.empty());
    EXPECT_EQ(read.left_color.size(), cv::Size(64, 48));
}

TEST(KeyframeStore, AMissingOrShortenedFileIsATypedError) {
    const TemporaryFolder folder;
    const KeyframeStore store(folder.path());
    EXPECT_THROW(store.read(1), Error);
    store.write(1, gradient_images());
    for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
        std::filesystem::resize_file(entry.path(), entry.file_size() - 1);
    EXPECT_THROW(store.read(1), Error);
}

}  // namespace
}  // namespace divemesh::worker
