#include "schemas/sequence_ranges.hpp"

#include <algorithm>
#include <iterator>

namespace divemesh {
namespace {

template <typename Ranges>
auto find_range(Ranges& ranges, std::int64_t sequence) {
    const auto after = ranges.upper_bound(sequence);
    if (after == ranges.begin() || std::prev(after)->second < sequence) return ranges.end();
    return std::prev(after);
}

void cover(std::map<std::int64_t, std::int64_t>& ranges, std::int64_t first, std::int64_t last) {
    auto touched = ranges.upper_bound(first);
    if (touched != ranges.begin() && std::prev(touched)->second >= first - 1) --touched;
    while (touched != ranges.end() && touched->first <= last + 1) {
        first = std::min(first, touched->first);
        last = std::max(last, touched->second);
        touched = ranges.erase(touched);
    }
    ranges.emplace(first, last);
}

}  // namespace

bool SequenceRanges::add(std::int64_t sequence) {
    if (find_range(ranges_, sequence) != ranges_.end()) return take_back(sequence);
    cover(ranges_, sequence, sequence);
    if (ranges_.size() > kMaxRanges) give_up(gaps().front());
    return true;
}

bool SequenceRanges::take_back(std::int64_t sequence) {
    const auto lost = find_range(lost_, sequence);
    if (lost == lost_.end()) return false;
    const auto [first, last] = *lost;
    lost_.erase(lost);
    if (first < sequence) lost_.emplace(first, sequence - 1);
    if (sequence < last) lost_.emplace(sequence + 1, last);
    --num_lost_;
    return true;
}

void SequenceRanges::give_up(const SequenceRange& range) {
    std::vector<SequenceRange> missing = gaps();
    missing.push_back({newest() + 1, std::max(newest() + 1, range.last)});
    for (const SequenceRange& gap : missing) {
        const std::int64_t first = std::max(gap.first, range.first);
        const std::int64_t last = std::min(gap.last, range.last);
        if (first > last) continue;
        num_lost_ += last - first + 1;
        cover(lost_, first, last);
    }
    cover(ranges_, range.first, range.last);
    while (lost_.size() > kMaxRanges) lost_.erase(lost_.begin());
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
    json = {{"ranges", ranges.ranges_}, {"lost", ranges.lost_}, {"num_lost", ranges.num_lost_}};
}

void from_json(const nlohmann::json& json, SequenceRanges& ranges) {
    json.at("ranges").get_to(ranges.ranges_);
    ranges.lost_ = json.value("lost", SequenceRanges::Ranges{});
    json.at("num_lost").get_to(ranges.num_lost_);
}

}  // namespace divemesh
