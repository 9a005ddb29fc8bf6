#pragma once

#include <utility>

#include "api/audit.hpp"
#include "api/handlers/json_body.hpp"
#include "api/in_pool.hpp"
#include "api/preconditions.hpp"
#include "api/read_nonblocking.hpp"
#include "schemas/json.hpp"

namespace divemesh::api {

// The common handlers for one resource. `read` and `remove` take the request and the catalog; they
// throw if the resource does not exist or the token does not see it.

// Responds with one object, which `read` finds by its keys: see read_nonblocking().
template <typename Read>
Awaitable<Response> get_resource(Request request, Services services, Read read) {
    auto find = [request, read](storage::Catalog& catalog) { return read(request, catalog); };
    const auto found = co_await read_nonblocking(services, std::move(find));
    co_return resource_response(request, found);
}

// Responds with a list; `read` returns all of it.
template <typename Read>
Awaitable<Response> get_list(Request request, Services services, Read read) {
    auto work = [&catalog = services.catalog, request, read] { return read(request, catalog); };
    const auto values = co_await in_pool(services.pool, std::move(work));
    co_return whole_list_response(request, values);
}

// Responds with a page of a list: `read` returns a storage::Page, for page_request().
template <typename Read>
Awaitable<Response> get_page(Request request, Services services, Read read) {
    auto work = [&catalog = services.catalog, request, read] { return read(request, catalog); };
    const auto page = co_await in_pool(services.pool, std::move(work));
    using Value = typename decltype(page.items)::value_type;
    co_return list_response<Value>(request, page.items, page.next_cursor);
}

// Changes a resource. `change` takes the request, audits what it does and returns what the resource
// became. Responds with 200 and that.
template <typename Change>
Awaitable<Response> change_resource(Request request, Services services, Change change) {
    auto work = [request, change] { return change(request); };
    const auto changed = co_await in_pool(services.pool, std::move(work));
    co_return json_response(http::status::ok, changed);
}

// Deletes a resource that GET shows as `read` returns it, so If-Match may name its tag. `remove`
// gets a catalog that audits the change, see audited_if_match(). Responds with 204.
template <typename Read, typename Remove>
Awaitable<Response> delete_resource(Request request, Services services, Read read, Remove remove) {
    auto work = [services, request, read, remove] {
        auto catalog = audited_if_match(services, request, [services, request, read] {
            return nlohmann::json(read(request, services.catalog));
        });
        remove(request, catalog);
    };
    co_await in_pool(services.pool, std::move(work));
    co_return empty_response(http::status::no_content);
}

// Deletes a resource that has no tag, because it has no GET of its own. `remove` gets a catalog
// that audits the change, see audited(). Responds with 204.
template <typename Remove>
Awaitable<Response> delete_untagged_resource(Request request, Services services, Remove remove) {
    require_no_tag(request);
    auto work = [services, request, remove] {
        auto catalog = audited(services, request);
        remove(request, catalog);
    };
    co_await in_pool(services.pool, std::move(work));
    co_return empty_response(http::status::no_content);
}

}  // namespace divemesh::api
