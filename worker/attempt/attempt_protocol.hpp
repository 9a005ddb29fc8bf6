#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "schemas/finding.hpp"
#include "schemas/job.hpp"
#include "schemas/measurement.hpp"
#include "schemas/truth_file.hpp"

// What the two processes of a worker say to each other. The parent writes one request file; the
// child answers on the pipe at kAttemptPipe, one JSON object a line.
namespace divemesh::attempt {

inline constexpr int kAttemptPipe = 3;                 // file descriptor in the child
inline constexpr std::size_t kMaxLineBytes = 4 << 20;  // a longer line is a broken child

struct AttemptRequest {
    JobKind kind = JobKind::Reconstruct;
    std::filesystem::path dive;     // archive on this machine
    std::filesystem::path out;      // artifacts: every file below becomes one
    std::filesystem::path scratch;  // removed by the parent
    std::filesystem::path cache;    // of stages, shared with other attempts; empty: none
    std::int64_t cache_bytes = 0;
    std::string preset;
    nlohmann::json options = nlohmann::json::object();
    // Of a report or a comparison.
    std::vector<std::filesystem::path> reconstructions;  // folders: `job`, then `with`
    std::map<std::string, std::filesystem::path> truth;  // by kind; `later_areas`: of `with`
    std::map<std::string, std::vector<double>> history;  // earlier figures, oldest first
    std::vector<Finding> findings;                       // of what a report is made of
};

// An intake's answer; the thumbnail is the file `thumbnail.jpg` in the request's out folder.
struct IntakeAnswer {
    std::vector<Finding> findings;
    std::string name;
    std::string site;
    std::string rig;
    std::vector<std::string> tags;
    std::string content_sha256;
    std::int64_t num_frames = 0;
    double duration_s = 0.0;
    bool has_thumbnail = false;
};

struct LogText {
    std::string text;
};

struct Done {};  // all that is to be kept lies in `out`

// An UnreadableTruth comes before the failure that it is the cause of.
using AttemptMessage = std::
    variant<Progress, LogText, StageRun, Measurement, UnreadableTruth, IntakeAnswer, Done, Failure>;

void to_json(nlohmann::json& json, const AttemptRequest& request);
void from_json(const nlohmann::json& json, AttemptRequest& request);

std::string encode_message(const AttemptMessage& message);  // one line with its newline
// Throws Error{BadData} when the line is none of ours.
AttemptMessage decode_message(const std::string& line);

}  // namespace divemesh::attempt
