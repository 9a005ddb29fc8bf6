#include "worker/recording/choose_topics.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

namespace divemesh::recording {
namespace {

// The words for the left camera in names of topics, and those for the right one.
constexpr std::pair<std::string_view, std::string_view> kSides[] = {
    {"left", "right"},
    {"cam0", "cam1"},
    {"cam_0", "cam_1"},
    {"camera0", "camera1"},
    {"camera_0", "camera_1"},
    {"infra1", "infra2"},
    {"fisheye1", "fisheye2"},
};
// What image_transport puts behind the name of the images that it compresses.
constexpr std::string_view kCompressed[] = {"/compressed", "/foxglove"};

bool is_image(const Topic& topic) {
    if (topic.name.ends_with("Depth")) return false;  // compressedDepth is no photograph
    return topic.type == "sensor_msgs/Image" || topic.type == "sensor_msgs/CompressedImage" ||
           is_video(topic);
}

bool is_compressed(const Topic& topic) { return topic.type != "sensor_msgs/Image"; }

bool is_static_transform(const Topic& topic) {
    return (topic.type == "tf2_msgs/TFMessage" || topic.type == "tf/tfMessage") &&
           topic.name.ends_with("tf_static");
}

using Places = std::vector<std::size_t>;

template <typename Condition>
Places places_where(const std::vector<Topic>& topics, const Condition& holds) {
    Places places;
    for (std::size_t i = 0; i < topics.size(); ++i)
        if (topics[i].num_messages > 0 && holds(topics[i])) places.push_back(i);
    return places;
}

Places places_of_type(const std::vector<Topic>& topics, std::string_view type) {
    return places_where(topics, [&](const Topic& topic) { return topic.type == type; });
}

std::optional<std::size_t> place_of(const std::vector<Topic>& topics,
                                    std::string_view name,
                                    std::string_view type) {
    for (std::size_t i = 0; i < topics.size(); ++i)
        if (topics[i].name == name && topics[i].type == type) return i;
    return std::nullopt;
}

std::string replaced(std::string text, std::string_view word, std::string_view by) {
    for (std::size_t at = text.find(word); at != std::string::npos;
         at = text.find(word, at + by.size()))
        text.replace(at, word.size(), by);
    return text;
}

// Returns the right camera's topic whose name is that of the left one with the other word.
std::optional<std::size_t> partner_of(const std::vector<Topic>& topics, const Topic& left) {
    for (const auto& [word, other] : kSides) {
        const std::string name = replaced(left.name, word, other);
        if (name == left.name) continue;
        const auto right = place_of(topics, name, left.type);
        if (right && topics[*right].num_messages > 0) return right;
    }
    return std::nullopt;
}

// Removes the compressed pairs, which show the same images, if others are left.
void prefer_uncompressed(const std::vector<Topic>& topics, Places& lefts) {
    const auto compressed = [&](std::size_t left) { return is_compressed(topics[left]); };
    if (!std::all_of(lefts.begin(), lefts.end(), compressed)) std::erase_if(lefts, compressed);
}

void choose_cameras(const std::vector<Topic>& topics, ChosenTopics& chosen) {
    Places lefts = places_where(topics, [&](const Topic& topic) {
        return is_image(topic) && partner_of(topics, topic).has_value();
    });
    prefer_uncompressed(topics, lefts);
    if (lefts.size() == 1) {
        chosen.left = lefts.front();
        chosen.right = partner_of(topics, topics[lefts.front()]);
        return;
    }
    chosen.problem = lefts.empty() ? "no two topics with images are named as a left and a right one"
                                   : std::to_string(lefts.size()) +
                                         " pairs of topics are named as left and right ones";
    chosen.problem += ": name the topics of the cameras by --left and --right";
}

// Finds the topic that a user names; anything else is a problem.
template <typename Condition>
std::optional<std::size_t> named_topic(const std::vector<Topic>& topics,
                                       const std::string& name,
                                       const Condition& holds,
                                       ChosenTopics& chosen) {
    const Places places = places_where(
        topics, [&](const Topic& topic) { return topic.name == name && holds(topic); });
    if (places.size() == 1) return places.front();
    chosen.problem = "the recording has no messages of this kind under '" + name +
                     "': use a name from the table";
    return std::nullopt;
}

// Returns the topic of CameraInfo beside a topic of images, where ROS's drivers have it.
std::optional<std::size_t> info_of(const std::vector<Topic>& topics,
                                   std::optional<std::size_t> image) {
    if (!image) return std::nullopt;
    std::string_view name = topics[*image].name;
    for (const std::string_view ending : kCompressed)
        if (name.ends_with(ending)) name.remove_suffix(ending.size());
    name = name.substr(0, name.rfind('/') + 1);
    return place_of(topics, std::string(name) + "camera_info", "sensor_msgs/CameraInfo");
}

void choose_imu(const std::vector<Topic>& topics, const std::string& named, ChosenTopics& chosen) {
    if (named == "none") return;
    const auto is_imu = [](const Topic& topic) { return topic.type == "sensor_msgs/Imu"; };
    if (!named.empty()) {
        chosen.imu = named_topic(topics, named, is_imu, chosen);
        return;
    }
    const Places imus = places_where(topics, is_imu);
    if (imus.size() == 1) chosen.imu = imus.front();
    if (imus.size() > 1 && chosen.problem.empty())
        chosen.problem = std::to_string(imus.size()) +
                         " topics hold an IMU: name one by --imu, or none of them by --imu none";
}

}  // namespace

std::string ChosenTopics::use_of(std::size_t topic) const {
    if (left == topic) return "left camera";
    if (right == topic) return "right camera";
    if (left_info == topic) return "calibration of the left camera";
    if (right_info == topic) return "calibration of the right camera";
    if (imu == topic) return "IMU";
    if (pressure == topic) return "depth";
    if (std::find(transforms.begin(), transforms.end(), topic) != transforms.end())
        return "poses of the sensors";
    return "";
}

ChosenTopics choose_topics(const std::vector<Topic>& topics, const NamedTopics& named) {
    ChosenTopics chosen;
    if (named.left.empty() && named.right.empty()) {
        choose_cameras(topics, chosen);
    } else if (named.left.empty() || named.right.empty()) {
        chosen.problem = "one camera alone is named: name both by --left and --right";
    } else {
        chosen.left = named_topic(topics, named.left, is_image, chosen);
        chosen.right = named_topic(topics, named.right, is_image, chosen);
    }
    if (chosen.left && chosen.right &&
        is_rectified(topics[*chosen.left]) != is_rectified(topics[*chosen.right]))
        chosen.problem = "one camera's images are rectified, the other's are not: name two alike";
    chosen.left_info = info_of(topics, chosen.left);
    chosen.right_info = info_of(topics, chosen.right);
    choose_imu(topics, named.imu, chosen);
    const Places pressures = places_of_type(topics, "sensor_msgs/FluidPressure");
    if (pressures.size() == 1) chosen.pressure = pressures.front();
    chosen.transforms = places_where(topics, is_static_transform);
    return chosen;
}

bool is_video(const Topic& topic) { return topic.type == "foxglove_msgs/CompressedVideo"; }

bool is_rectified(const Topic& topic) {
    std::string_view rest = topic.name;
    while (!rest.empty()) {
        const std::string_view word = rest.substr(0, rest.find_first_of("/_"));
        if (word == "rect" || word == "rectified") return true;
        rest.remove_prefix(std::min(rest.size(), word.size() + 1));
    }
    return false;
}

}  // namespace divemesh::recording
