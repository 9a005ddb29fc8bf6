#pragma once

#include <functional>
#include <string>

#include "api/client/backoff.hpp"
#include "api/client/rest_client.hpp"
#include "schemas/dive.hpp"
#include "schemas/shown_job.hpp"

namespace divemesh::api::client {

using OnJob = std::function<void(const ShownJob& job)>;

// Waits until a job has finished and returns it. Follows the events; if they are not available, it
// polls every second. Survives a server that is away for the account's give_up_after.
Job follow_job(RestClient& rest,
               const std::string& job_id,
               const OnJob& on_job,
               const Backoff::OnWait& on_wait);

// Waits until intake has decided and returns the dive: ready or refused.
Dive follow_dive(RestClient& rest, const std::string& dive_id, const Backoff::OnWait& on_wait);

}  // namespace divemesh::api::client
