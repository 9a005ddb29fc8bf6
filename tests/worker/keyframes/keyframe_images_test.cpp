#include "worker/keyframes/keyframe_images.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "tests/temporary_folder.hpp"

namespace divemesh::keyframes {
namespace {

class KeyframeImagesTest : public testing::Test {
protected:
    KeyframeImagesTest() {
        rig_.width_px = 640;
        rig_.height_px = 480;
        rig_.focal_px = 500.0;
        for (const int frame_index : {3, 12}) {
            types::Keyframe keyframe;
            keyframe.frame_index = frame_index;
            keyframe.timestamp_ns = 1'403'636'579'763'555'584 + frame_index;
            keyframe.T_world_cam.translation().x() = frame_index;
            keyframes_.push_back(keyframe);
        }
    }

    TemporaryFolder folder_;
    types::RectifiedRig rig_;
    std::vector<types::Keyframe> keyframes_;
    const ReadImage read_ = [](int) { return cv::Mat(480, 640, CV_8UC3, cv::Scalar(40, 80, 120)); };
};

TEST_F(KeyframeImagesTest, EveryKeyframeHasAPoseAndASmallImage) {
    write_keyframe_images(folder_.path(), rig_, keyframes_, read_, 2, base::ignore_progress);
    const auto json = nlohmann::json::parse(std::ifstream(folder_ / "keyframes.json"));
    ASSERT_EQ(json["keyframes"].size(), 2U);
    const auto& second = json["keyframes"][1];
    EXPECT_EQ(second["timestamp_ns"], 1'403'636'579'763'555'596);
    EXPECT_EQ(second["position_m"], nlohmann::json({12.0, 0.0, 0.0}));
    EXPECT_EQ(second["picture"], "keyframes/000012.jpg");
    const cv::Mat image = cv::imread((folder_ / "keyframes/000012.jpg").string());
    EXPECT_EQ(image.size(), cv::Size(320, 240));
    EXPECT_NEAR(image.at<cv::Vec3b>(100, 100)[2], 120, 4);
}

TEST_F(KeyframeImagesTest, StopsWhenTheCallbackCancels) {
    const auto cancel = [](const Progress&) { throw Error(ErrorCode::Cancelled, "stop"); };
    EXPECT_THROW(write_keyframe_images(folder_.path(), rig_, keyframes_, read_, 2, cancel), Error);
}

}  // namespace
}  // namespace divemesh::keyframes
