#pragma once

#include "api/http.hpp"
#include "api/services.hpp"
#include "schemas/dive.hpp"
#include "schemas/job.hpp"
#include "schemas/upload.hpp"

namespace divemesh::api {

// What the path names by {upload_id}, {dive_id} or {job_id}. Throws Error{NotFound} alike when it
// does not exist and when the token does not see its project, Error{Gone} for an upload that ended.
// Block: for the pool.
Upload visible_upload(const Request& request, const Services& services);
Dive visible_dive(const Request& request, const Services& services);
Job visible_job(const Request& request, const Services& services);

}  // namespace divemesh::api
