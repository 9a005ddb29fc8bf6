#include "worker/recording/container.hpp"

#include <algorithm>
#include <system_error>

#include "schemas/error.hpp"
#include "worker/recording/bag_folder.hpp"
#include "worker/recording/db3_container.hpp"
#include "worker/recording/mcap_container.hpp"
#include "worker/recording/ros1_container.hpp"
#include "worker/recording/unpack.hpp"
#include "worker/recording/unpacked_file.hpp"

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
    else
        text +=
            " is no recording that is read: give an MCAP file (.mcap), a ROS bag (.bag, .db3) or "
            "its "
            "folder, a video (MP4, MOV, MKV, AVI), or a folder of images";
    throw Error(ErrorCode::BadData, text);
}

// Opens one file that is not compressed as a whole.
std::unique_ptr<Container> opened_file(InputFile file,
                                       dive::FindingLog& findings,
                                       const base::ProgressCallback& progress) {
    const std::string head = file.read(0, std::ssize(kSqliteMagic));
    if (head.starts_with(kMcapMagic))
        return std::make_unique<McapContainer>(std::move(file), findings, progress);
    if (head.starts_with(kRos1Magic))
        return std::make_unique<Ros1Container>(std::move(file), findings, progress);
    if (head.starts_with(kSqliteMagic))
        return std::make_unique<Db3Container>(std::move(file), findings, progress);
    fail_as_unknown(file);
}

std::unique_ptr<Container> opened(const std::filesystem::path& path,
                                  dive::FindingLog& findings,
                                  const base::ProgressCallback& progress) {
    std::error_code failure;
    if (std::filesystem::is_directory(path, failure))
        return std::make_unique<BagFolder>(path, findings, progress);
    InputFile file(path);
    if (!file.read(0, std::ssize(kZstdMagic)).starts_with(kZstdMagic))
        return opened_file(std::move(file), findings, progress);
    // The container holds it open, so it can lose its name.
    const UnpackedFile unpacked(file, findings, progress);
    return opened_file(InputFile(unpacked.path()), findings, progress);
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

void Container::count_unpacked(std::int64_t num_bytes) {
    unpacked_bytes_ += num_bytes;
    if (!is_bomb(unpacked_bytes_, packed_bytes_)) return;
    throw Error(ErrorCode::TooLarge,
                file_.path().string() + " of " + std::to_string(packed_bytes_) +
                    " bytes unpacks to more than 100 times its size or 512 GiB, like a "
                    "decompression bomb: record compressed images, which hardly shrink, or split "
                    "the recording");
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
    const std::string head = file.read(0, std::ssize(kSqliteMagic));
    return head.starts_with(kMcapMagic) || head.starts_with(kRos1Magic) ||
           head.starts_with(kSqliteMagic);
}

std::unique_ptr<Container> open_container(const std::filesystem::path& path,
                                          dive::FindingLog& findings,
                                          const base::ProgressCallback& progress) {
    auto container = opened(path, findings, progress);
    if (container->blocks().empty())
        throw Error(ErrorCode::BadData,
                    path.string() +
                        " holds no message that can be read: copy the recording again, or record "
                        "again if the original is as short");
    return container;
}

}  // namespace divemesh::recording
