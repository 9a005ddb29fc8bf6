#pragma once

#include "api/http.hpp"
#include "api/services.hpp"
#include "schemas/shown_job.hpp"

namespace divemesh::api {

// Returns a job with what is computed when it is asked for: when it starts, or why not. Blocks.
ShownJob with_forecast(Job job, const Services& services, storage::Catalog& catalog);

// Adds when the result of a job was deleted. Blocks.
void add_deletion(ShownJob& job, storage::Catalog& catalog);

// Return a job, and the job of the request's path, as GET shows it. Block.
ShownJob shown_job(Job job, const Services& services, storage::Catalog& catalog);
ShownJob shown_job(const Request& request, const Services& services, storage::Catalog& catalog);

// Returns the catalog for a change of that job, see audited_if_match().
storage::Catalog audited_if_job_matches(const Services& services, const Request& request);

}  // namespace divemesh::api
