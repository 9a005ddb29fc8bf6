#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

namespace divemesh {

struct SequenceRange {
    std::int64_t first = 0;
    std::int64_t last = 0;
};

// Which of the messages 0, 1, 2 ... of one boot have come, in whatever order. Bounded: of more gaps
// than are kept the lowest is given up, and counts as lost until it comes after all. Of what was
// given up the last kMaxRanges stretches are remembered.
class SequenceRanges {
public:
    static constexpr std::size_t kMaxRanges = 256;

    bool add(std::int64_t sequence);  // false: it was there
    // What the sender gave up itself: it does not come any more.
    void give_up(const SequenceRange& range);

    std::int64_t acknowledged() const;  // it and all before it have come or are lost; -1: none
    std::int64_t newest() const;        // -1: none
    std::vector<SequenceRange> gaps() const;
    std::int64_t num_lost() const { return num_lost_; }

    friend void to_json(nlohmann::json& json, const SequenceRanges& ranges);
    friend void from_json(const nlohmann::json& json, SequenceRanges& ranges);

private:
    using Ranges = std::map<std::int64_t, std::int64_t>;  // first to last; never two that touch

    bool take_back(std::int64_t sequence);

    Ranges ranges_;  // come or given up
    Ranges lost_;    // of these, what was given up
    std::int64_t num_lost_ = 0;
};

void to_json(nlohmann::json& json, const SequenceRange& range);

}  // namespace divemesh
