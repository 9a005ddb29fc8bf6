#pragma once

#include <filesystem>
#include <string>

#include "api/client/backoff.hpp"
#include "api/client/dive_tar.hpp"
#include "api/client/rest_client.hpp"
#include "cli/progress_bar.hpp"
#include "schemas/dive.hpp"
#include "schemas/job.hpp"

namespace divemesh::cli {

// Shows "track  42 %  12.3 frames/s, 0:42 left" on the bar.
void show_progress(ProgressBar& bar, const Progress& progress);

// Returns a callback that shows on the bar how many of `total` bytes are done.
api::client::BytesDone show_bytes(ProgressBar& bar, const std::string& label, std::int64_t total);

// Prints "connection lost ...; again in 3 s" above the bar.
api::client::Backoff::OnWait say_waiting(ProgressBar& bar);

// Shows a job's progress until it has finished, and returns the job.
Job wait_for_job(api::client::RestClient& rest, const std::string& job_id);

// Waits for intake and returns the dive; prints the findings if it is refused.
Dive wait_for_dive(api::client::RestClient& rest, const std::string& dive_id);

// Downloads artifacts of a job into a folder, with a bar.
void download_job(api::client::RestClient& rest,
                  const std::string& job_id,
                  const std::vector<std::string>& names,  // empty: all of them
                  const std::filesystem::path& folder);

// Prints the metrics of a finished job as a table on stderr, if it has some, with its findings and
// verdict.
void print_job_metrics(api::client::RestClient& rest, const Job& job);

// Prints why a job did not succeed: its failure, its own findings and verdict, and those of a
// refused dive.
void print_failure(api::client::RestClient& rest, const Job& job);

// Waits for a job and prints its metrics, or why it did not succeed. Downloads its artifacts, those
// of a result that is not usable too, unless `folder` is empty. Returns whether it succeeded.
bool fetch_results(api::client::RestClient& rest,
                   const std::string& job_id,
                   const std::filesystem::path& folder);

}  // namespace divemesh::cli
