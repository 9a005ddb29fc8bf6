#include "worker/recording/bag_folder.hpp"

#include <algorithm>
#include <string>
#include <string_view>
#include <system_error>

#include "schemas/error.hpp"

namespace divemesh::recording {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxFiles = 10'000;
constexpr std::int64_t kMaxMetadata_bytes = std::int64_t{16} << 20U;
constexpr std::string_view kCompressed = ".zstd";
constexpr std::string_view kEndings[] = {".db3", ".mcap", ".db3.zstd", ".mcap.zstd"};

bool is_bag_file(std::string_view name) {
    if (name.starts_with('.')) return false;  // of macOS, beside the file itself
    return std::any_of(std::begin(kEndings), std::end(kEndings), [&](std::string_view ending) {
        return name.ends_with(ending);
    });
}

// Returns the names of files that metadata.yaml lists ("    - bag_0.db3"), with or without a folder
// in front.
std::vector<std::string> named_files(const fs::path& metadata) {
    std::vector<std::string> names;
    if (!fs::is_regular_file(metadata)) return names;
    const std::string text = InputFile(metadata).read(0, kMaxMetadata_bytes);
    for (std::size_t at = 0; at < text.size() && names.size() < kMaxFiles;) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        std::string_view line = std::string_view(text).substr(at, end - at);
        at = end + 1;
        line.remove_prefix(std::min(line.find_first_not_of(' '), line.size()));
        if (line.ends_with('\r')) line.remove_suffix(1);
        if (!line.starts_with("- ")) continue;
        line.remove_prefix(2);
        line.remove_prefix(line.rfind('/') + 1);  // npos + 1 is 0
        if (is_bag_file(line) && line.size() <= kMaxName_bytes) names.emplace_back(line);
    }
    return names;
}

// Returns whether a file is there, compressed or not.
bool is_there(const fs::path& file) {
    fs::path other = file;
    if (file.extension() == kCompressed)
        other.replace_extension();
    else
        other += kCompressed;
    return fs::exists(file) || fs::exists(other);
}

// Returns what passes the progress of one file on as its share of that of all.
base::ProgressCallback share_of(const base::ProgressCallback& progress,
                                std::size_t part,
                                std::size_t num_parts) {
    return [&progress, part, num_parts](Progress state) {
        state.fraction =
            (0.5 * static_cast<double>(part) + state.fraction) / static_cast<double>(num_parts);
        progress(state);
    };
}

}  // namespace

std::vector<fs::path> files_of_recording(const fs::path& path) {
    std::error_code failure;
    if (!fs::is_directory(path, failure)) return {path};
    std::vector<fs::path> files;
    const fs::directory_iterator entries(path, failure);
    if (failure)
        throw Error(ErrorCode::Unavailable,
                    "cannot read " + path.string() + ": " + failure.message() +
                        ": check the right to read it");
    for (const auto& entry : entries) {
        const std::string name = entry.path().filename().string();
        if (!is_bag_file(name) || !entry.is_regular_file()) continue;
        // rosbag2 leaves the decompressed file beside the compressed one.
        if (name.ends_with(kCompressed) && fs::exists(path / entry.path().stem())) continue;
        if (files.size() == kMaxFiles)
            throw Error(ErrorCode::BadData,
                        path.string() + " has more files than a bag: give that of one dive");
        files.push_back(entry.path());
    }
    if (files.empty())
        throw Error(ErrorCode::BadData,
                    path.string() +
                        " has no .db3 or .mcap file of a ROS 2 bag: give the folder "
                        "that ros2 bag record wrote, or the file itself");
    std::sort(files.begin(), files.end());
    return files;
}

BagFolder::BagFolder(const fs::path& folder,
                     dive::FindingLog& findings,
                     const base::ProgressCallback& progress)
    : Container(InputFile(files_of_recording(folder).front())) {
    for (const std::string& name : named_files(folder / "metadata.yaml"))
        if (!is_there(folder / name))
            findings.warning("recording_part_missing",
                             name,
                             "metadata.yaml names this file, which is missing",
                             "Copy the whole folder again.");
    const auto files = files_of_recording(folder);
    std::string last_problem;
    for (std::size_t i = 0; i < files.size(); ++i) try {
            add_part(open_container(files[i], findings, share_of(progress, i, files.size())));
        } catch (const Error& error) {
            if (error.code() != ErrorCode::BadData) throw;
            last_problem = error.what();
            findings.warning("recording_part_unreadable",
                             files[i].filename().string(),
                             "a file of the bag is left out: " + last_problem,
                             "Copy the whole folder again.");
        }
    if (parts_.empty()) throw Error(ErrorCode::BadData, last_problem);
}

void BagFolder::add_part(std::unique_ptr<Container> container) {
    BagPart part;
    for (const Topic& topic : container->topics()) {
        const auto place = topic_of(topic.name, topic.type, topic.serialization);
        part.topics.push_back(place.value_or(kMaxTopics));
        if (place) topics_[*place].num_messages += topic.num_messages;
    }
    for (Block block : container->blocks()) {
        block.part = parts_.size();
        blocks_.push_back(block);
    }
    part.container = std::move(container);
    parts_.push_back(std::move(part));
}

BlockContents BagFolder::read(const Block& block) const {
    const BagPart& part = parts_[block.part];
    BlockContents contents = part.container->read(block);
    for (BlockMessage& message : contents.messages) message.topic = part.topics[message.topic];
    std::erase_if(contents.messages,
                  [](const BlockMessage& message) { return message.topic == kMaxTopics; });
    return contents;
}

}  // namespace divemesh::recording
