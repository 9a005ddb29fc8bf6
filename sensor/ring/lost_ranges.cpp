#include "sensor/ring/lost_ranges.hpp"

#include <algorithm>
#include <iterator>

namespace divemesh::sensor {

void LostRanges::add(const SequenceRange& range) {
    auto [first, last] = range;
    auto touched = ranges_.upper_bound(first);
    if (touched != ranges_.begin() && std::prev(touched)->second >= first - 1) --touched;
    while (touched != ranges_.end() && touched->first <= last + 1) {
        first = std::min(first, touched->first);
        last = std::max(last, touched->second);
        touched = ranges_.erase(touched);
    }
    ranges_.emplace(first, last);
}

void LostRanges::remove(const SequenceRange& range) {
    auto touched = ranges_.upper_bound(range.first);
    if (touched != ranges_.begin() && std::prev(touched)->second >= range.first) --touched;
    while (touched != ranges_.end() && touched->first <= range.last) {
        const auto [first, last] = *touched;
        touched = ranges_.erase(touched);
        if (first < range.first) ranges_.emplace(first, range.first - 1);
        if (last > range.last) ranges_.emplace(range.last + 1, last);
    }
}

std::vector<SequenceRange> LostRanges::first(std::size_t max_num_ranges) const {
    std::vector<SequenceRange> ranges;
    for (const auto& [first, last] : ranges_) {
        if (ranges.size() == max_num_ranges) break;
        ranges.push_back({first, last});
    }
    return ranges;
}

}  // namespace divemesh::sensor
