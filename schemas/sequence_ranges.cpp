#include "schemas/sequence_ranges.hpp"

#include <algorithm>
#include <iterator>

namespace divemesh {

bool SequenceRanges::contains(std::int64_t sequence) const {
    const auto after = ranges_.upper_bound(sequence);
    return after != ranges_.begin() && std::prev(after)->second >= sequence;
}

void SequenceRanges::cover(std::int64_t first, std::int64_t last) {
    auto touched = ranges_.upper_bound(first);
    if (touched != ranges_.begin() && std::prev(touched)->second >= first - 1) --touched;
    while (touched != ranges_.end() && touched->first <= last + 1) {
        first = std::min(first, touched->first);
        last = std::max(last, touched->second);
        touched = ranges_.erase(touched);
    }
    ranges_.emplace(first, last);
}

bool SequenceRanges::add(std::int64_t sequence) {
    if (contains(sequence)) return false;
    cover(sequence, sequence);
    if (ranges_.size() > kMostRanges) give_up(gaps().front());
    return true;
}

void SequenceRanges::give_up(const SequenceRange& range) {
    std::int64_t first = range.first;
    for (const SequenceRange& gap : gaps())
        if (gap.first <= range.last && gap.last >= range.first)
            num_lost_ += std::min(gap.last, range.last) - std::max(gap.first, range.first) + 1;
    num_lost_ += std::max<std::int64_t>(0, range.last - std::max(first - 1, newest()));
    cover(first, range.last);
}

std::int64_t SequenceRanges::acknowledged() const {
    return ranges_.empty() || ranges_.begin()->first > 0 ? -1 : ranges_.begin()->second;
}

std::int64_t SequenceRanges::newest() const {
    return ranges_.empty() ? -1 : std::prev(ranges_.end())->second;
}

std::vector<SequenceRange> SequenceRanges::gaps() const {
    std::vector<SequenceRange> gaps;
    std::int64_t next = 0;
    for (const auto& [first, last] : ranges_) {
        if (first > next) gaps.push_back({next, first - 1});
        next = last + 1;
    }
    return gaps;
}

void to_json(nlohmann::json& json, const SequenceRange& range) {
    json = {{"first", range.first}, {"last", range.last}};
}

void to_json(nlohmann::json& json, const SequenceRanges& ranges) {
    json = {{"ranges", ranges.ranges_}, {"num_lost", ranges.num_lost_}};
}

void from_json(const nlohmann::json& json, SequenceRanges& ranges) {
    json.at("ranges").get_to(ranges.ranges_);
    json.at("num_lost").get_to(ranges.num_lost_);
}

}  // namespace divemesh
