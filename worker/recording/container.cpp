#include "worker/recording/container.hpp"

#include <algorithm>

#include "schemas/error.hpp"
#include "worker/recording/mcap_container.hpp"
#include "worker/recording/ros1_container.hpp"

namespace divemesh::recording {
namespace {

// Returns "sensor_msgs/Image" for "sensor_msgs/msg/Image", as ROS 2 names it.
std::string type_of_either_ros(std::string_view type) {
    std::string plain(type);
    const std::size_t at = plain.find("/msg/");
    if (at != std::string::npos) plain.erase(at, 4);
    return plain;
}

[[noreturn]] void fail_as_unknown(const InputFile& file) {
    const std::string head = file.read(0, 13);
    std::string text = file.path().string();
    if (head.starts_with("#ROSBAG V"))
        text += " is a ROS bag older than 2.0: convert it by rosbag migrate";
    else if (head.starts_with("SQLite format"))
        text +=
            " is a ROS 2 bag in SQLite, which is not read: convert it by ros2 bag convert, with "
            "storage_id: mcap in its options";
    else
        text += " is neither MCAP nor a ROS 1 bag: give the .mcap or .bag file itself";
    throw Error(ErrorCode::BadData, text);
}

}  // namespace

std::optional<std::size_t> Container::topic_of(std::string_view name,
                                               std::string_view type,
                                               Serialization serialization) {
    if (name.size() > kMaxName_bytes || type.size() > kMaxName_bytes) return std::nullopt;
    const std::pair key(std::string(name), type_of_either_ros(type));
    const auto found = places_.find(key);
    if (found != places_.end()) return found->second;
    if (topics_.size() == kMaxTopics) return std::nullopt;
    topics_.push_back({key.first, key.second, serialization, 0});
    return places_.emplace(key, topics_.size() - 1).first->second;
}

void Container::add_block(Block block, const BlockContents& contents) {
    if (contents.messages.empty()) return;
    const auto [first, last] = std::minmax_element(
        contents.messages.begin(), contents.messages.end(), [](const auto& a, const auto& b) {
            return a.log_time_ns < b.log_time_ns;
        });
    block.first_ns = first->log_time_ns;
    block.last_ns = last->log_time_ns;
    for (const BlockMessage& message : contents.messages) ++topics_[message.topic].num_messages;
    blocks_.push_back(block);
}

void Container::report_cut(std::int64_t offset_bytes, dive::FindingLog& findings) const {
    findings.warning("recording_cut",
                     file_.path().filename().string() + ":" + std::to_string(offset_bytes),
                     "the recording is cut or damaged from byte " + std::to_string(offset_bytes) +
                         " of " + std::to_string(file_.size_bytes()) +
                         " on; what is before is used",
                     "Copy it again if the original is longer.");
}

void Container::report_damage(std::int64_t offset_bytes,
                              const std::string& what,
                              dive::FindingLog& findings) const {
    findings.warning("recording_damaged",
                     file_.path().filename().string() + ":" + std::to_string(offset_bytes),
                     what,
                     "Copy the recording again; if the original is damaged too, the rest is used.");
}

bool is_container(const InputFile& file) {
    const std::string head = file.read(0, 13);
    return head.starts_with(kMcapMagic) || head.starts_with(kRos1Magic);
}

std::unique_ptr<Container> open_container(const std::filesystem::path& path,
                                          dive::FindingLog& findings,
                                          const base::ProgressCallback& progress) {
    InputFile file(path);
    const std::string head = file.read(0, 13);
    std::unique_ptr<Container> container;
    if (head.starts_with(kMcapMagic))
        container = std::make_unique<McapContainer>(std::move(file), findings, progress);
    else if (head.starts_with(kRos1Magic))
        container = std::make_unique<Ros1Container>(std::move(file), findings, progress);
    else
        fail_as_unknown(file);
    if (container->blocks().empty())
        throw Error(ErrorCode::BadData,
                    path.string() +
                        " holds no message that can be read: copy the recording again, or record "
                        "again if the original is as short");
    return container;
}

}  // namespace divemesh::recording
