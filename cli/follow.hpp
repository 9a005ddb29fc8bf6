#pragma once

#include <filesystem>
#include <string>

#include "api/client/backoff.hpp"
#include "api/client/rest_client.hpp"
#include "cli/progress_bar.hpp"
#include "schemas/dive.hpp"
#include "schemas/job.hpp"

namespace divemesh::cli {

// "track  42 %  12.3 frames/s, 0:42 left" on the bar.
void show_progress(ProgressBar& bar, const Progress& progress);

// "connection lost ...; again in 3 s" above the bar.
api::client::Backoff::OnWait say_waiting(ProgressBar& bar);

// Shows a job live until it is finished.
Job wait_for_job(api::client::RestClient& rest, const std::string& job_id);

// Waits for intake; prints the findings when the dive is refused.
Dive wait_for_dive(api::client::RestClient& rest, const std::string& dive_id);

// Artifacts of a job into a folder, with a bar.
void download_job(api::client::RestClient& rest,
                  const std::string& job_id,
                  const std::vector<std::string>& names,  // none: all of them
                  const std::filesystem::path& folder);

// The metrics of a finished job as a table on stderr; nothing when it has none.
void print_job_metrics(api::client::RestClient& rest, const std::string& job_id);

// What somebody has to know when a job did not succeed: its failure and the dive's findings.
void print_failure(api::client::RestClient& rest, const Job& job);

}  // namespace divemesh::cli
