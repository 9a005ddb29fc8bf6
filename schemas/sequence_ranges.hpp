#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

namespace divemesh {

// Sequence numbers from `first` to `last`, both included.
struct SequenceRange {
    std::int64_t first = 0;
    std::int64_t last = 0;
};

// Which of the messages 0, 1, 2 ... of one boot were received, in any order. Bounded: if there are
// too many gaps, the lowest is given up and counts as lost until it arrives after all. The last
// kMaxRanges lost ranges are remembered.
class SequenceRanges {
public:
    static constexpr std::size_t kMaxRanges = 256;

    bool add(std::int64_t sequence);  // false: already received
    // Gives up messages that the sender no longer has.
    void give_up(const SequenceRange& range);

    std::int64_t acknowledged() const;  // received or lost up to here; -1: no message
    std::int64_t newest() const;        // -1: no message
    std::vector<SequenceRange> gaps() const;
    std::int64_t num_lost() const { return num_lost_; }

    friend void to_json(nlohmann::json& json, const SequenceRanges& ranges);
    friend void from_json(const nlohmann::json& json, SequenceRanges& ranges);

private:
    using Ranges = std::map<std::int64_t, std::int64_t>;  // first to last; no two are adjacent

    bool take_back(std::int64_t sequence);

    Ranges ranges_;  // received or given up
    Ranges lost_;    // those given up
    std::int64_t num_lost_ = 0;
};

void to_json(nlohmann::json& json, const SequenceRange& range);

}  // namespace divemesh
