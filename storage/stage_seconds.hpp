#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "schemas/job.hpp"

namespace soci {
class session;
}

namespace divemesh::storage {

// Upper bounds of the classes for durations of stages, seconds.
inline constexpr std::array<double, 12> kStageBounds_s = {
    0.1, 1.0, 5.0, 10.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1800.0, 3600.0, 14400.0};

// How long one stage took in all attempts that ran it.
struct StageSeconds {
    std::string stage;
    std::array<std::int64_t, kStageBounds_s.size() + 1> num_runs = {};  // by class; last: beyond
    double total_s = 0.0;
    std::int64_t num_cached = 0;  // not run, because the cache had its result
};

// Counts a run of a known stage (kStageNames); ignores other names.
void count_stage(soci::session& session, const StageRun& run);
std::vector<StageSeconds> read_stage_seconds(soci::session& session);

}  // namespace divemesh::storage
