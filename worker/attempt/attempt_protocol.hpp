#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "schemas/content_hash.hpp"
#include "schemas/dive.hpp"
#include "schemas/finding.hpp"
#include "schemas/job.hpp"
#include "schemas/measurement.hpp"
#include "schemas/truth_file.hpp"

// The protocol between the two processes of a worker. The parent writes one request file; the child
// answers on the pipe at kAttemptPipe, one JSON object per line.
namespace divemesh::attempt {

inline constexpr int kAttemptPipe = 3;                 // file descriptor in the child
inline constexpr std::size_t kMaxLineBytes = 4 << 20;  // a longer line means a broken child

// The contents of the request file.
struct AttemptRequest {
    JobKind kind = JobKind::Reconstruct;
    std::filesystem::path dive;     // archive on this machine
    std::filesystem::path out;      // every file below it becomes an artifact
    std::filesystem::path scratch;  // removed by the parent
    std::filesystem::path cache;    // of stages, shared with other attempts; empty: no cache
    std::int64_t cache_bytes = 0;
    std::string preset;
    nlohmann::json options = nlohmann::json::object();
    // For a report or a comparison.
    std::vector<std::filesystem::path> reconstructions;  // folders: `job`, then `with`
    std::map<std::string, std::filesystem::path> truth;  // by kind; `later_areas`: those of `with`
    std::map<std::string, std::vector<double>> history;  // earlier metrics, oldest first
    std::vector<Finding> findings;                       // of the reconstructions in a report
};

// The result of an intake; the thumbnail is the file `thumbnail.jpg` in the request's out folder.
struct IntakeAnswer {
    std::vector<Finding> findings;
    std::string name;
    std::string site;
    std::string rig;
    std::vector<std::string> tags;
    std::string notes;
    std::optional<DivePosition> position;
    ContentHash content_sha256;
    std::int64_t num_frames = 0;
    double duration_s = 0.0;
    bool has_thumbnail = false;
};

// Text for the log of the job.
struct LogText {
    std::string text;
};

struct Done {};  // all results are in `out`

// An UnreadableTruth precedes the failure that it causes.
using AttemptMessage = std::
    variant<Progress, LogText, StageRun, Measurement, UnreadableTruth, IntakeAnswer, Done, Failure>;

void to_json(nlohmann::json& json, const AttemptRequest& request);
void from_json(const nlohmann::json& json, AttemptRequest& request);

std::string encode_message(const AttemptMessage& message);  // one line with its newline
// Throws Error{BadData} if the line is not a valid message.
AttemptMessage decode_message(const std::string& line);

}  // namespace divemesh::attempt
