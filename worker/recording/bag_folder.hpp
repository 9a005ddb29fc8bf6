#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "worker/recording/container.hpp"

namespace divemesh::recording {

// Returns the files of a recording: the file itself, or those of a folder that rosbag2 writes (.db3
// and .mcap, also compressed), in the order of their names. Throws Error{BadData} if a folder has
// none or too many.
std::vector<std::filesystem::path> files_of_recording(const std::filesystem::path& path);

// A ROS 2 bag that is split over the files of a folder, as one recording. A file that cannot be
// read, and one that metadata.yaml names and is missing, is a warning.
class BagFolder final : public Container {
public:
    // Throws Error{BadData} if no file can be read.
    BagFolder(const std::filesystem::path& folder,
              dive::FindingLog& findings,
              const base::ProgressCallback& progress);

    BlockContents read(const Block& block) const override;

private:
    struct BagPart {
        std::unique_ptr<Container> container;
        std::vector<std::size_t> topics;  // places in topics() of its topics; kMaxTopics: none
    };
    void add_part(std::unique_ptr<Container> container);

    std::vector<BagPart> parts_;
};

}  // namespace divemesh::recording
