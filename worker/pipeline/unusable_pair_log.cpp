#include "worker/pipeline/unusable_pair_log.hpp"

#include <utility>

#include "worker/base/seconds.hpp"

namespace divemesh::pipeline {

void UnusablePairLog::add_frame(std::int64_t index, std::int64_t timestamp_ns) {
    if (num_frames_ == 0) {
        first_index_ = index;
        first_ns_ = last_ns_ = timestamp_ns;
    }
    if (index > next_index_)
        runs_.push_back(
            {next_index_, index - next_index_, num_frames_, base::to_s(timestamp_ns - last_ns_)});
    next_index_ = index + 1;
    last_ns_ = timestamp_ns;
    ++num_frames_;
}

std::vector<types::UnusablePairs> UnusablePairLog::finish(std::int64_t num_pairs) {
    if (num_pairs > next_index_)
        runs_.push_back({next_index_, num_pairs - next_index_, num_frames_, 0.0});
    const std::int64_t num_periods = next_index_ - 1 - first_index_;
    const double period_s =
        num_periods > 0 ? base::to_s(last_ns_ - first_ns_) / static_cast<double>(num_periods) : 0.0;
    for (types::UnusablePairs& run : runs_)
        if (run.next_frame == 0 || run.next_frame == num_frames_)
            run.duration_s = period_s * static_cast<double>(run.num);
    return std::exchange(runs_, {});
}

}  // namespace divemesh::pipeline
