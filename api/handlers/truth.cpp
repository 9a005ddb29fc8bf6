#include "api/handlers/truth.hpp"

#include "api/handlers/resource.hpp"
#include "api/uploads/make_truth.hpp"
#include "api/visible.hpp"
#include "storage/truth_store.hpp"

namespace divemesh::api {

Awaitable<Response> list_truth(Request request, Services services) {
    auto read = [](const Request& asked, storage::Catalog& catalog) {
        return storage::TruthStore(catalog).list(visible_dive(asked, catalog).id);
    };
    return get_list(std::move(request), services, read);
}

Awaitable<Response> get_truth(Request request, Services services) {
    auto read = [](const Request& asked, storage::Catalog& catalog) {
        const Dive dive = visible_dive(asked, catalog);
        return storage::TruthStore(catalog).get(dive.id, asked.parameter("truth_id"));
    };
    return get_resource(std::move(request), services, read);
}

Awaitable<Response> delete_truth(Request request, Services services) {
    auto remove = [services](const Request& asked, storage::Catalog& catalog) {
        const Dive dive = visible_dive(asked, catalog);
        storage::TruthStore(catalog).remove(dive.id, asked.parameter("truth_id"));
        remove_deleted_truth(services);
    };
    return delete_resource(std::move(request), services, remove);
}

}  // namespace divemesh::api
