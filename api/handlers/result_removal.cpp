#include "api/handlers/result_removal.hpp"

#include "api/authorization.hpp"
#include "api/handlers/json_body.hpp"
#include "api/handlers/resource.hpp"
#include "api/handlers/shown_jobs.hpp"
#include "api/housekeeping.hpp"
#include "api/visible.hpp"
#include "schemas/json.hpp"
#include "storage/result_removal.hpp"

namespace divemesh::api {

Awaitable<Response> delete_job(Request request, Services services) {
    auto remove = [services](const Request& asked) {
        const bool purge = flag_value(asked, "purge");
        if (purge) require_scope(asked.token, "admin");
        const std::string id = visible_job(asked, services.catalog).id;
        auto catalog = audited_if_job_matches(services, asked);
        storage::ResultRemoval(catalog).remove(
            id, purge ? std::chrono::milliseconds(0) : services.limits.keep_deleted);
        if (purge) remove_expired_results(services);
        services.tokens.clear();  // of sharing links
        return shown_job(asked, services, services.catalog);
    };
    return change_resource(std::move(request), services, remove);
}

Awaitable<Response> restore_job(Request request, Services services) {
    auto restore = [services](const Request& asked) {
        const std::string id = visible_job(asked, services.catalog).id;
        auto catalog = audited_if_job_matches(services, asked);
        storage::ResultRemoval(catalog).restore(id);
        return shown_job(asked, services, services.catalog);
    };
    return change_resource(std::move(request), services, restore);
}

}  // namespace divemesh::api
