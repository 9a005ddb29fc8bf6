#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "worker/base/observer.hpp"
#include "worker/dive/finding_log.hpp"
#include "worker/recording/input_file.hpp"

namespace divemesh::recording {

// The largest block that is read, compressed or not: an image of 64 megapixels in colour fits
// twice.
inline constexpr std::int64_t kMaxBlock_bytes = std::int64_t{512} << 20U;
// The most topics of a recording; they are counted before they are kept.
inline constexpr std::size_t kMaxTopics = 10'000;

// The longest name of a topic or type that is kept.
inline constexpr std::size_t kMaxName_bytes = 1024;

// How the messages of a topic are written as bytes.
enum class Serialization { Ros1, Cdr, Unknown };

// The messages that one name stands for in a recording.
struct Topic {
    std::string name;  // "/camera/left/image_raw"
    std::string type;  // "sensor_msgs/Image", of ROS 1 and ROS 2 alike
    Serialization serialization = Serialization::Unknown;
    std::int64_t num_messages = 0;
};

// A stretch of a recording that is read as a whole: a chunk, records outside of chunks, or rows.
struct Block {
    std::size_t part = 0;    // of a recording in several files, the place of its file
    std::int64_t begin = 0;  // its first byte in the file, or its first row
    std::int64_t end = 0;    // behind its last

    std::int64_t size() const { return end - begin; }
    std::int64_t first_ns = 0;  // of the log times of its messages
    std::int64_t last_ns = 0;
};

// A message in the bytes of its block.
struct BlockMessage {
    std::size_t topic = 0;  // its place in Container::topics()
    std::int64_t log_time_ns = 0;
    std::size_t offset_bytes = 0;
    std::size_t size_bytes = 0;
};

// A block in memory, decompressed.
struct BlockContents {
    std::string bytes;
    std::vector<BlockMessage> messages;  // in the order of the file
};

// A recording's file in one of the formats that robots record in, independent of which one.
class Container {
public:
    virtual ~Container() = default;

    const InputFile& file() const { return file_; }
    const std::vector<Topic>& topics() const { return topics_; }
    const std::vector<Block>& blocks() const { return blocks_; }  // in the order of the file
    virtual BlockContents read(const Block& block) const = 0;

protected:
    explicit Container(InputFile file)
        : file_(std::move(file)), packed_bytes_(file_.size_bytes()) {}

    // Returns the place of a topic, which is added if it is new; nullopt beyond kMaxTopics or for a
    // name that no recorder writes.
    std::optional<std::size_t> topic_of(std::string_view name,
                                        std::string_view type,
                                        Serialization serialization);
    // Counts bytes that a part of the file unpacked to. Throws Error{TooLarge} if is_bomb().
    void count_unpacked(std::int64_t num_bytes);
    // Counts the messages of a block and keeps its place, if it has some.
    void add_block(Block block, const BlockContents& contents);
    // Reports that the rest of the file, or a part of it, cannot be read.
    void report_cut(std::int64_t offset_bytes, dive::FindingLog& findings) const;
    void report_damage(std::int64_t offset_bytes,
                       const std::string& what,
                       dive::FindingLog& findings) const;

    InputFile file_;
    std::int64_t packed_bytes_;  // that everything unpacks from
    std::vector<Topic> topics_;
    std::vector<Block> blocks_;

private:
    std::map<std::pair<std::string, std::string>, std::size_t> places_;  // by name and type
    std::int64_t unpacked_bytes_ = 0;
};

// Returns true for a file that begins as a recording in a format that open_container() reads.
bool is_container(const InputFile& file);

// Opens a recording by its first bytes: a file, also one that Zstandard compressed as a whole, or
// the folder of a ROS 2 bag. Every block is read once, indexed or not; what is damaged is left out
// with a warning. Throws Error{BadData} if it is no recording of a known format, or holds no
// message that can be read.
std::unique_ptr<Container> open_container(const std::filesystem::path& path,
                                          dive::FindingLog& findings,
                                          const base::ProgressCallback& progress);

}  // namespace divemesh::recording
