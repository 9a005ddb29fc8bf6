#include "api/visible.hpp"

#include "api/authorization.hpp"
#include "storage/dive_store.hpp"
#include "storage/job_store.hpp"
#include "storage/schedule_store.hpp"
#include "storage/sensor_store.hpp"
#include "storage/upload_store.hpp"

namespace divemesh::api {

Upload visible_upload(const Request& request, storage::Catalog& catalog) {
    const std::string& id = request.parameter("upload_id");
    Upload upload = storage::UploadStore(catalog).get(id);
    require_visible(request.token, upload.project, "upload " + id);
    storage::require_open(upload);
    return upload;
}

Dive visible_dive(const Request& request, storage::Catalog& catalog) {
    const std::string& id = request.parameter("dive_id");
    Dive dive = storage::DiveStore(catalog).get(id);
    require_visible(request.token, dive.project, "dive " + id);
    return dive;
}

Sensor visible_sensor(const Request& request, storage::Catalog& catalog) {
    const std::string& id = request.parameter("sensor_id");
    Sensor sensor = storage::SensorStore(catalog).get(id);
    require_visible(request.token, sensor.project, "sensor " + id);
    return sensor;
}

Schedule visible_schedule(const Request& request, storage::Catalog& catalog) {
    const std::string& id = request.parameter("schedule_id");
    Schedule schedule = storage::ScheduleStore(catalog).get(id);
    require_visible(request.token, schedule.project, "schedule " + id);
    return schedule;
}

Job visible_job(const Request& request, storage::Catalog& catalog) {
    const std::string& id = request.parameter("job_id");
    Job job = storage::JobStore(catalog).get(id);
    require_visible(request.token, job.project, "job " + id);
    return job;
}

}  // namespace divemesh::api
