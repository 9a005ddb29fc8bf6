#include "api/handlers/truth.hpp"

#include "api/audit.hpp"
#include "api/handlers/json_body.hpp"
#include "api/in_pool.hpp"
#include "api/make_truth.hpp"
#include "api/preconditions.hpp"
#include "api/visible.hpp"
#include "schemas/json.hpp"
#include "storage/truth_store.hpp"

namespace divemesh::api {

Awaitable<Response> list_truth(Request request, Services services) {
    auto work = [services, request] {
        const Dive dive = visible_dive(request, services.catalog);
        return storage::TruthStore(services.catalog).list(dive.id);
    };
    const auto files = co_await in_pool(services.pool, std::move(work));
    co_return whole_list_response(request, files);
}

Awaitable<Response> get_truth(Request request, Services services) {
    auto work = [services, request] {
        const Dive dive = visible_dive(request, services.catalog);
        return storage::TruthStore(services.catalog).get(dive.id, request.parameter("truth_id"));
    };
    const TruthFile file = co_await in_pool(services.pool, std::move(work));
    co_return resource_response(request, file);
}

Awaitable<Response> delete_truth(Request request, Services services) {
    require_no_tag(request);
    auto work = [services, request] {
        const Dive dive = visible_dive(request, services.catalog);
        auto catalog = audited(services, request);
        storage::TruthStore(catalog).remove(dive.id, request.parameter("truth_id"));
        remove_deleted_truth(services);
    };
    co_await in_pool(services.pool, std::move(work));
    co_return empty_response(http::status::no_content);
}

}  // namespace divemesh::api
