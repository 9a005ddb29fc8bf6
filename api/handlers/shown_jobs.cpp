#include "api/handlers/shown_jobs.hpp"

#include <utility>

#include "api/preconditions.hpp"
#include "api/visible.hpp"
#include "schemas/json.hpp"
#include "storage/result_removal.hpp"

namespace divemesh::api {

ShownJob with_forecast(Job job, const Services& services, storage::Catalog& catalog) {
    ShownJob shown;
    static_cast<Job&>(shown) = std::move(job);
    shown.forecast = services.forecast.of(shown, catalog);
    shown.waits_for = services.forecast.waits_for(shown, catalog);
    return shown;
}

void add_deletion(ShownJob& job, storage::Catalog& catalog) {
    if (!is_finished(job.state)) return;
    const auto deletion = storage::ResultRemoval(catalog).deletion_of(job.id);
    job.deleted_at_ms = deletion.deleted_at_ms;
    job.expires_at_ms = deletion.expires_at_ms;
}

ShownJob shown_job(Job job, const Services& services, storage::Catalog& catalog) {
    ShownJob shown = with_forecast(std::move(job), services, catalog);
    add_deletion(shown, catalog);
    return shown;
}

ShownJob shown_job(const Request& request, const Services& services, storage::Catalog& catalog) {
    return shown_job(visible_job(request, catalog), services, catalog);
}

storage::Catalog audited_if_job_matches(const Services& services, const Request& request) {
    return audited_if_match(services, request, [services, request] {
        return shown_job(request, services, services.catalog);
    });
}

}  // namespace divemesh::api
