#include "worker/pipeline/stage_time.hpp"

#include <ctime>
#include <utility>

#include "worker/base/seconds.hpp"

namespace divemesh::pipeline {
namespace {

double clock_s(clockid_t clock) {
    timespec now{};
    clock_gettime(clock, &now);
    return static_cast<double>(now.tv_sec) + base::to_s(now.tv_nsec);
}

}  // namespace

Stopwatch::Stopwatch()
    : wall_start_s_(clock_s(CLOCK_MONOTONIC)), cpu_start_s_(clock_s(CLOCK_PROCESS_CPUTIME_ID)) {}

StageTime Stopwatch::stop(std::string stage) const {
    return {std::move(stage),
            clock_s(CLOCK_MONOTONIC) - wall_start_s_,
            clock_s(CLOCK_PROCESS_CPUTIME_ID) - cpu_start_s_};
}

}  // namespace divemesh::pipeline
