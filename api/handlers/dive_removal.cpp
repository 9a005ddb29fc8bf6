#include "api/handlers/dive_removal.hpp"

#include "api/audit.hpp"
#include "api/authorization.hpp"
#include "api/etag.hpp"
#include "api/handlers/json_body.hpp"
#include "api/handlers/resource.hpp"
#include "api/housekeeping.hpp"
#include "api/preconditions.hpp"
#include "api/visible.hpp"
#include "schemas/json.hpp"
#include "storage/dive_removal.hpp"

namespace divemesh::api {

Awaitable<Response> delete_dive(Request request, Services services) {
    auto remove = [services](const Request& asked) {
        const Dive seen = visible_dive(asked, services.catalog);
        const auto unchanged = [&](const Dive& dive) { require_match(asked, json_text(dive)); };
        const bool purge = flag_value(asked, "purge");
        if (purge) require_scope(asked.token, "admin");
        auto catalog = audited(services, asked);
        const auto keep = purge ? std::chrono::milliseconds(0) : services.limits.keep_deleted;
        Dive dive = storage::DiveRemoval(catalog).remove(seen.id, keep, unchanged);
        if (purge) remove_expired_dives(services);
        services.tokens.clear();  // of sharing links
        return dive;
    };
    return change_resource(std::move(request), services, remove);
}

Awaitable<Response> restore_dive(Request request, Services services) {
    auto restore = [services](const Request& asked) {
        auto catalog = audited_if_match(
            services, asked, [services, asked] { return visible_dive(asked, services.catalog); });
        return storage::DiveRemoval(catalog).restore(visible_dive(asked, catalog).id,
                                                     services.limits.max_project_dives);
    };
    return change_resource(std::move(request), services, restore);
}

}  // namespace divemesh::api
