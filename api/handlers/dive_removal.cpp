#include "api/handlers/dive_removal.hpp"

#include "api/audit.hpp"
#include "api/authorization.hpp"
#include "api/etag.hpp"
#include "api/handlers/json_body.hpp"
#include "api/housekeeping.hpp"
#include "api/in_pool.hpp"
#include "api/preconditions.hpp"
#include "api/visible.hpp"
#include "schemas/json.hpp"
#include "storage/dive_removal.hpp"

namespace divemesh::api {

Awaitable<Response> delete_dive(Request request, Services services) {
    auto work = [services, request] {
        const Dive seen = visible_dive(request, services.catalog);
        const auto unchanged = [&](const Dive& dive) { require_match(request, json_text(dive)); };
        const bool purge = flag_value(request, "purge");
        if (purge) require_scope(request.token, "admin");
        auto catalog = audited(services, request);
        const auto keep = purge ? std::chrono::milliseconds(0) : services.limits.keep_deleted;
        Dive dive = storage::DiveRemoval(catalog).remove(seen.id, keep, unchanged);
        if (purge) remove_expired_dives(services);
        return dive;
    };
    const Dive dive = co_await in_pool(services.pool, std::move(work));
    co_return json_response(http::status::ok, dive);
}

Awaitable<Response> restore_dive(Request request, Services services) {
    auto work = [services, request] {
        auto catalog = audited_if_match(services, request, [services, request] {
            return visible_dive(request, services.catalog);
        });
        return storage::DiveRemoval(catalog).restore(visible_dive(request, catalog).id,
                                                     services.limits.max_project_dives);
    };
    const Dive dive = co_await in_pool(services.pool, std::move(work));
    co_return json_response(http::status::ok, dive);
}

}  // namespace divemesh::api
