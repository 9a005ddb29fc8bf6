#include "worker/recording/choose_topics.hpp"

#include <gtest/gtest.h>

namespace divemesh::recording {
namespace {

Topic topic(const std::string& name, const std::string& type, std::int64_t num_messages = 10) {
    return {name, "sensor_msgs/" + type, Serialization::Ros1, num_messages};
}

TEST(ChooseTopicsTest, APairIsFoundByTheWordsForItsSides) {
    for (const auto& [left, right] : std::vector<std::pair<std::string, std::string>>{
             {"/stereo/left/image_raw", "/stereo/right/image_raw"},
             {"/cam0/image_raw", "/cam1/image_raw"},
             {"/camera/infra1/image_rect_raw", "/camera/infra2/image_rect_raw"}}) {
        const auto chosen =
            choose_topics({topic(right, "Image"), topic(left, "Image"), topic("/imu", "Imu")}, {});
        EXPECT_EQ(chosen.problem, "");
        EXPECT_EQ(chosen.left, 1U) << left;
        EXPECT_EQ(chosen.right, 0U);
        EXPECT_EQ(chosen.imu, 2U);
    }
}

TEST(ChooseTopicsTest, CameraInfoIsBesideTheImagesCompressedOrNot) {
    const auto chosen = choose_topics({topic("/left/image_raw/compressed", "CompressedImage"),
                                       topic("/right/image_raw/compressed", "CompressedImage"),
                                       topic("/left/image_raw/camera_info", "CameraInfo"),
                                       topic("/left/camera_info", "CameraInfo"),
                                       topic("/right/camera_info", "CameraInfo")},
                                      {});
    EXPECT_EQ(chosen.problem, "");
    EXPECT_EQ(chosen.left_info, 3U);
    EXPECT_EQ(chosen.right_info, 4U);
}

TEST(ChooseTopicsTest, ImagesThatAreNotCompressedArePreferred) {
    const auto chosen = choose_topics({topic("/left/image_raw/compressed", "CompressedImage"),
                                       topic("/right/image_raw/compressed", "CompressedImage"),
                                       topic("/left/image_raw", "Image"),
                                       topic("/right/image_raw", "Image"),
                                       topic("/left/image_raw/compressedDepth", "CompressedImage")},
                                      {});
    EXPECT_EQ(chosen.problem, "");
    EXPECT_EQ(chosen.left, 2U);
}

TEST(ChooseTopicsTest, WhatIsNotClearIsAProblemThatNamesTheOption) {
    const std::vector<Topic> two_pairs = {topic("/left/image_raw", "Image"),
                                          topic("/right/image_raw", "Image"),
                                          topic("/left/image_rect", "Image"),
                                          topic("/right/image_rect", "Image"),
                                          topic("/a", "Imu"),
                                          topic("/b", "Imu")};
    EXPECT_NE(choose_topics(two_pairs, {}).problem.find("--left"), std::string::npos);
    NamedTopics named = {"/left/image_rect", "/right/image_rect", ""};
    EXPECT_NE(choose_topics(two_pairs, named).problem.find("--imu"), std::string::npos);
    named.imu = "none";
    EXPECT_EQ(choose_topics(two_pairs, named).problem, "");
    EXPECT_EQ(choose_topics(two_pairs, named).left, 2U);
    named.imu = "/b";
    EXPECT_EQ(choose_topics(two_pairs, named).imu, 5U);
    named.left = "/imagined";
    EXPECT_NE(choose_topics(two_pairs, named).problem.find("/imagined"), std::string::npos);
    const std::vector<Topic> no_pair = {topic("/front", "Image"), topic("/down", "Image")};
    EXPECT_NE(choose_topics(no_pair, {}).problem.find("--left"), std::string::npos);
    const std::vector<Topic> empty_right = {topic("/left", "Image"), topic("/right", "Image", 0)};
    EXPECT_NE(choose_topics(empty_right, {}).problem, "");
}

TEST(ChooseTopicsTest, RectifiedImagesAreToldByTheWordAlone) {
    EXPECT_TRUE(is_rectified(topic("/left/image_rect_color", "Image")));
    EXPECT_TRUE(is_rectified(topic("/left/rect/image", "Image")));
    EXPECT_FALSE(is_rectified(topic("/direct/left/image_raw", "Image")));
    const NamedTopics named = {"/left/image_rect", "/right/image_raw", ""};
    const auto chosen = choose_topics(
        {topic("/left/image_rect", "Image"), topic("/right/image_raw", "Image")}, named);
    EXPECT_NE(chosen.problem.find("rectified"), std::string::npos);
}

}  // namespace
}  // namespace divemesh::recording
