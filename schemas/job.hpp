#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "schemas/artifact.hpp"
#include "schemas/error.hpp"
#include "schemas/finding.hpp"
#include "schemas/job_state.hpp"
#include "schemas/measurement.hpp"
#include "schemas/verdict.hpp"

namespace divemesh {

enum class JobKind { Intake, Reconstruct, AccuracyReport, Compare };

std::string_view to_string(JobKind kind);
JobKind job_kind_from_string(std::string_view text);  // throws Error{InvalidArgument}

// Progress of a job. The pipeline reports it through one callback.
struct Progress {
    std::string stage;      // of kStageNames; a run of stages fills it in
    double fraction = 0.0;  // of the whole job, 0 to 1
    std::int64_t frames_done = 0;
    std::int64_t num_frames = 0;
    double frames_per_s = 0.0;
    double seconds_left = -1.0;  // negative: not yet known
};

// Why an attempt or a job failed, and what to do.
struct Failure {
    ErrorCode code = ErrorCode::Unavailable;
    std::string message;  // "" without a failure
    std::string remedy;   // "": usual_remedy(code) applies
};

// Returns the remedy for a failure of this class if no better one is known.
std::string_view usual_remedy(ErrorCode code);

// The stages of a reconstruction, in order; "publish" ends every job.
inline constexpr std::array<std::string_view, 7> kStageNames = {
    "track", "optimise", "fuse", "mesh", "texture", "evaluate", "publish"};

// A finished stage of the newest attempt.
struct StageRun {
    std::string name;  // one of kStageNames
    double seconds = 0.0;
    bool from_cache = false;  // an earlier attempt or job had computed it
};

// The forecast for a queued job. Negative: unknown.
struct Forecast {
    std::int64_t position = 0;  // 1: next
    double starts_in_s = -1.0;
    double takes_s = -1.0;
};

// One request for work. Times are unix milliseconds (wall clock of the catalog).
struct Job {
    std::string id;
    std::string project;
    std::string dive_id;
    JobKind kind = JobKind::Reconstruct;
    JobState state = JobState::Queued;
    std::string preset;                                 // of a reconstruction
    nlohmann::json options = nlohmann::json::object();  // overrides of the preset
    std::vector<std::string> parents;  // all of these must succeed before it starts
    int priority = 0;                  // each step is worth ten minutes of waiting
    bool paused = false;               // held by a user
    bool lowered = false;              // memory ran out: the next attempt uses the least possible
    int num_attempts = 0;              // begun so far
    int max_attempts = 3;
    bool cancel_requested = false;
    Progress progress;
    std::vector<StageRun> stages;
    std::optional<Forecast> forecast;  // computed on request, not stored
    Failure failure;
    std::vector<RequirementResult> requirements;  // of a report that succeeded
    std::optional<Verdict> verdict;               // of a reconstruction that has ended
    std::vector<Finding> findings;                // of the same; those on its dive are among them
    std::int64_t not_before_ms = 0;
    std::int64_t created_at_ms = 0;
    std::int64_t started_at_ms = 0;   // of the newest attempt; 0: never
    std::int64_t finished_at_ms = 0;  // 0: not finished
};

// Returns good, usable_with_restrictions or not_usable for a reconstruction; passed or failed for a
// report with requirements; otherwise "".
std::string_view verdict_of(const Job& job);

// A worker's right to write to a job. Every write carries it; one with a stale lease changes
// nothing.
struct Lease {
    std::string job_id;
    int attempt = 0;
    std::string lease_id;  // random, 128 bit, hex
};

// One run of a job by a worker. Times are unix milliseconds (wall clock of the catalog).
struct Attempt {
    std::string job_id;
    int number = 0;
    AttemptState state = AttemptState::Running;
    std::string worker;  // host:pid
    Failure failure;
    std::int64_t started_at_ms = 0;
    std::int64_t finished_at_ms = 0;  // 0: running
};

}  // namespace divemesh
