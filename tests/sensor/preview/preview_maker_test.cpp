#include "sensor/preview/preview_maker.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "schemas/error.hpp"

namespace divemesh::sensor {
namespace {

cv::Mat noise(int width, int height, int type = CV_8UC1) {
    cv::Mat image(height, width, type);
    cv::randu(image, 0, 255);
    return image;
}

cv::Mat decoded(const Preview& preview) {
    return cv::imdecode(std::vector<char>(preview.jpeg.begin(), preview.jpeg.end()),
                        cv::IMREAD_UNCHANGED);
}

TEST(PreviewTest, TakesThreeSecondsOfTheLink) {
    EXPECT_EQ(preview_budget(8192.0), 24 << 10);
    EXPECT_EQ(preview_budget(0.0), 24 << 10);
    EXPECT_EQ(preview_budget(1e9), 256 << 10);
    EXPECT_EQ(preview_budget(10.0), 4 << 10);
}

TEST(PreviewTest, KeepsToItsBudgetWhateverIsSeen) {
    for (const std::int64_t budget : {2 << 10, 24 << 10, 100 << 10, 256 << 10, 1 << 30})
        for (const cv::Mat& image : {noise(752, 480),
                                     noise(1920, 1080, CV_8UC3),
                                     cv::Mat(480, 640, CV_8U, cv::Scalar(7))}) {
            const Preview preview = make_preview(image, budget);
            EXPECT_LE(preview.jpeg.size(), std::min<std::size_t>(budget, kMaxPreviewBytes));
            const cv::Mat seen = decoded(preview);
            EXPECT_EQ(seen.cols, preview.width_px);
            EXPECT_EQ(seen.rows, preview.height_px);
        }
}

TEST(PreviewTest, RefusesABudgetThatNoImageHas) {
    EXPECT_THROW(make_preview(noise(640, 480), 100), Error);
}

TEST(PreviewTest, ShowsBothCamerasSideBySide) {
    const FrameImages frame{1, noise(64, 48), noise(64, 48, CV_8UC3)};
    const cv::Mat pair = image_of(frame, View::Pair);
    EXPECT_EQ(pair.size(), cv::Size(128, 48));
    EXPECT_TRUE(image_of({1, noise(64, 48), {}}, View::Pair).empty());
}

TEST(PreviewTest, DrawsTracks) {
    const cv::Mat grey(48, 64, CV_8U, cv::Scalar(0));
    const TrackLine track{{10, 10}, {20, 20}};
    EXPECT_GT(cv::countNonZero(with_tracks(grey, {&track, 1}).reshape(1)), 10);
}

}  // namespace
}  // namespace divemesh::sensor
