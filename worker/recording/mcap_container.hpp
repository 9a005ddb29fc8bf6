#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>

#include "worker/recording/chunked_container.hpp"

namespace divemesh::recording {

inline constexpr std::string_view kMcapMagic = "\x89MCAP0\r\n";

// A recording in MCAP (mcap.dev/spec), read from front to end: indices are not needed. Channels are
// known by the numbers of the file.
class McapContainer final : public ChunkedContainer {
public:
    McapContainer(InputFile file,
                  dive::FindingLog& findings,
                  const base::ProgressCallback& progress);

private:
    OpenedBlock open(std::string bytes) const override;
    void learn(std::string_view records) override;
    BlockContents parse(std::string bytes) const override;
    void learn_summary();
    void scan(dive::FindingLog& findings, const base::ProgressCallback& progress);
    void learn_schema(std::string_view content);
    void learn_channel(std::string_view content);

    std::unordered_map<std::uint16_t, std::string> schemas_;   // names of types
    std::unordered_map<std::uint16_t, std::size_t> channels_;  // places in topics()
};

}  // namespace divemesh::recording
