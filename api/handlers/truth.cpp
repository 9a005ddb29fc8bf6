#include "api/handlers/truth.hpp"

#include "api/handlers/resource.hpp"
#include "api/uploads/make_truth.hpp"
#include "api/visible.hpp"
#include "storage/truth_store.hpp"

namespace divemesh::api {
namespace {

auto shown_truth(const Request& request, storage::Catalog& catalog) {
    const Dive dive = visible_dive(request, catalog);
    return storage::TruthStore(catalog).get(dive.id, request.parameter("truth_id"));
}

}  // namespace

Awaitable<Response> list_truth(Request request, Services services) {
    auto read = [](const Request& asked, storage::Catalog& catalog) {
        return storage::TruthStore(catalog).list(visible_dive(asked, catalog).id);
    };
    return get_list(std::move(request), services, read);
}

Awaitable<Response> get_truth(Request request, Services services) {
    return get_resource(std::move(request), services, shown_truth);
}

Awaitable<Response> delete_truth(Request request, Services services) {
    auto remove = [services](const Request& asked, storage::Catalog& catalog) {
        const Dive dive = visible_dive(asked, catalog);
        storage::TruthStore(catalog).remove(dive.id, asked.parameter("truth_id"));
        remove_deleted_truth(services);
    };
    return delete_resource(std::move(request), services, shown_truth, remove);
}

}  // namespace divemesh::api
