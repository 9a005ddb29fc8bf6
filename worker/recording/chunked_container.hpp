#pragma once

#include <string>
#include <string_view>

#include "worker/recording/container.hpp"

namespace divemesh::recording {

// The decompressed records of a block, or what is wrong with it. A chunk that the file cuts gives
// the records before the cut.
struct OpenedBlock {
    std::string bytes;
    std::string problem;  // "" if there is none
};

// A file of records, of which some are chunks: further records, compressed. What the format is,
// its class says.
class ChunkedContainer : public Container {
public:
    BlockContents read(const Block& block) const final;

protected:
    using Container::Container;

    // Adds a chunk or a run of records, unless it is damaged. Throws as count_unpacked() does.
    void add(const Block& block, dive::FindingLog& findings);

    // Learns the topics that records state.
    virtual void learn(std::string_view records) = 0;

private:
    virtual OpenedBlock open(std::string bytes) const = 0;
    // Finds the messages in decompressed records, up to where these are cut.
    virtual BlockContents parse(std::string bytes) const = 0;
};

}  // namespace divemesh::recording
