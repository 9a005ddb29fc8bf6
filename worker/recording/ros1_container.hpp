#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>

#include "worker/recording/chunked_container.hpp"

namespace divemesh::recording {

inline constexpr std::string_view kRos1Magic = "#ROSBAG V2.0\n";

// A ROS 1 bag, version 2.0 (wiki.ros.org/Bags/Format/2.0), read from front to end: indices are not
// needed, so a bag whose recording was interrupted (.bag.active) is read too.
class Ros1Container final : public ChunkedContainer {
public:
    Ros1Container(InputFile file,
                  dive::FindingLog& findings,
                  const base::ProgressCallback& progress);

private:
    OpenedBlock open(std::string bytes) const override;
    void learn(std::string_view records) override;
    BlockContents parse(std::string bytes) const override;
    void scan(dive::FindingLog& findings, const base::ProgressCallback& progress);
    void learn_connection(std::string_view header, std::string_view data);

    std::unordered_map<std::uint32_t, std::size_t> connections_;  // places in topics()
};

}  // namespace divemesh::recording
