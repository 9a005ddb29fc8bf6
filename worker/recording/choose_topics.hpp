#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "worker/recording/container.hpp"

namespace divemesh::recording {

// The topics that a user names; "" where the names and types of the recording decide.
struct NamedTopics {
    std::string left;
    std::string right;
    std::string imu;  // "none": no IMU
};

// The topics that a dive is made from, by their places in the list.
struct ChosenTopics {
    std::optional<std::size_t> left;
    std::optional<std::size_t> right;
    std::optional<std::size_t> left_info;  // its sensor_msgs/CameraInfo
    std::optional<std::size_t> right_info;
    std::optional<std::size_t> imu;
    std::optional<std::size_t> pressure;
    std::vector<std::size_t> transforms;  // tf_static
    std::string problem;  // why the choice is not clear, and what to do; "" if it is

    // Returns what a topic is used for, for people; "" if it is not.
    std::string use_of(std::size_t topic) const;
};

// Chooses topics by type, and the pair of cameras by the words in which their names differ, such as
// left and right or cam0 and cam1. Whatever is not clear is a problem.
ChosenTopics choose_topics(const std::vector<Topic>& topics, const NamedTopics& named);

// Returns whether the images of a topic are a stream of video.
bool is_video(const Topic& topic);

// Returns whether a topic holds rectified images: its name has the word rect, as image_proc gives
// it.
bool is_rectified(const Topic& topic);

}  // namespace divemesh::recording
