#pragma once

#include "api/http.hpp"
#include "schemas/dive.hpp"
#include "schemas/job.hpp"
#include "schemas/schedule.hpp"
#include "schemas/sensor.hpp"
#include "schemas/upload.hpp"
#include "storage/catalog.hpp"

namespace divemesh::api {

// Return the object that the path names by {upload_id}, {dive_id}, {sensor_id}, {schedule_id} or
// {job_id}. Throw the same Error{NotFound} if it does not exist and if the token does not see its
// project, and Error{Gone} for an upload that ended. They read from `catalog` and block as it does.
Upload visible_upload(const Request& request, storage::Catalog& catalog);
Dive visible_dive(const Request& request, storage::Catalog& catalog);
Sensor visible_sensor(const Request& request, storage::Catalog& catalog);
Schedule visible_schedule(const Request& request, storage::Catalog& catalog);
Job visible_job(const Request& request, storage::Catalog& catalog);

}  // namespace divemesh::api
