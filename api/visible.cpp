#include "api/visible.hpp"

#include "api/authorization.hpp"
#include "storage/dive_store.hpp"
#include "storage/job_store.hpp"
#include "storage/schedule_store.hpp"
#include "storage/sensor_store.hpp"
#include "storage/upload_store.hpp"

namespace divemesh::api {
namespace {

// Returns the object of `Store` that the path names by {<word>_id}.
template <typename Store>
auto visible(const Request& request, storage::Catalog& catalog, const std::string& word) {
    const std::string& id = request.parameter(word + "_id");
    auto found = Store(catalog).get(id);
    require_visible(request.token, found.project, word + " " + id);
    return found;
}

}  // namespace

Upload visible_upload(const Request& request, storage::Catalog& catalog) {
    Upload upload = visible<storage::UploadStore>(request, catalog, "upload");
    storage::require_open(upload);
    return upload;
}

Dive visible_dive(const Request& request, storage::Catalog& catalog) {
    return visible<storage::DiveStore>(request, catalog, "dive");
}

Sensor visible_sensor(const Request& request, storage::Catalog& catalog) {
    return visible<storage::SensorStore>(request, catalog, "sensor");
}

Schedule visible_schedule(const Request& request, storage::Catalog& catalog) {
    return visible<storage::ScheduleStore>(request, catalog, "schedule");
}

Job visible_job(const Request& request, storage::Catalog& catalog) {
    return visible<storage::JobStore>(request, catalog, "job");
}

}  // namespace divemesh::api
