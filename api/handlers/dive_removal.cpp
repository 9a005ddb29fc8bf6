#include "api/handlers/dive_removal.hpp"

#include "api/audit.hpp"
#include "api/etag.hpp"
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
        auto catalog = audited(services, request);
        return storage::DiveRemoval(catalog).remove(
            seen.id, services.limits.keep_deleted, unchanged);
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
