#pragma once

#include "api/http.hpp"
#include "schemas/dive.hpp"
#include "schemas/job.hpp"
#include "schemas/schedule.hpp"
#include "schemas/sensor.hpp"
#include "schemas/upload.hpp"
#include "storage/catalog.hpp"

namespace divemesh::api {

// What the path names by {upload_id}, {dive_id}, {sensor_id}, {schedule_id} or {job_id}. Throws
// Error{NotFound} alike when it does not exist and when the token does not see its project,
// Error{Gone} for an upload that ended. Read from `catalog`: block as that does.
Upload visible_upload(const Request& request, storage::Catalog& catalog);
Dive visible_dive(const Request& request, storage::Catalog& catalog);
Sensor visible_sensor(const Request& request, storage::Catalog& catalog);
Schedule visible_schedule(const Request& request, storage::Catalog& catalog);
Job visible_job(const Request& request, storage::Catalog& catalog);

}  // namespace divemesh::api
