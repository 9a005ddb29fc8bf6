#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "schemas/sequence_ranges.hpp"

namespace divemesh::sensor {

// Messages of one boot that this device has lost, until the server knows.
class LostRanges {
public:
    void add(const SequenceRange& range);
    void remove(const SequenceRange& range);
    bool empty() const { return ranges_.empty(); }
    std::vector<SequenceRange> first(std::size_t max_num_ranges) const;

private:
    std::map<std::int64_t, std::int64_t> ranges_;  // first to last; no two are adjacent
};

}  // namespace divemesh::sensor
