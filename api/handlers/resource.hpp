#pragma once

#include <utility>

#include "api/audit.hpp"
#include "api/handlers/json_body.hpp"
#include "api/in_pool.hpp"
#include "api/preconditions.hpp"
#include "api/read_nonblocking.hpp"
#include "schemas/json.hpp"

namespace divemesh::api {

// What most handlers do once they know what is asked for. `read` and `remove` take the request and
// the catalog; they throw where it is not there or the token does not see it.

// Answers with one object, which `read` finds by its keys: see read_nonblocking().
template <typename Read>
Awaitable<Response> get_resource(Request request, Services services, Read read) {
    auto find = [request, read](storage::Catalog& catalog) { return read(request, catalog); };
    const auto found = co_await read_nonblocking(services, std::move(find));
    co_return resource_response(request, found);
}

// Answers with a list, of which `read` returns all.
template <typename Read>
Awaitable<Response> get_list(Request request, Services services, Read read) {
    auto work = [&catalog = services.catalog, request, read] { return read(request, catalog); };
    const auto values = co_await in_pool(services.pool, std::move(work));
    co_return whole_list_response(request, values);
}

// Answers with a page of a list: `read` returns a storage::Page, for page_request().
template <typename Read>
Awaitable<Response> get_page(Request request, Services services, Read read) {
    auto work = [&catalog = services.catalog, request, read] { return read(request, catalog); };
    const auto page = co_await in_pool(services.pool, std::move(work));
    using Value = typename decltype(page.items)::value_type;
    co_return list_response<Value>(request, page.items, page.next_cursor);
}

// Deletes what no GET answers with a tag: `remove` gets the catalog for a change in the name of who
// asks, see audited(). Answers 204.
template <typename Remove>
Awaitable<Response> delete_resource(Request request, Services services, Remove remove) {
    require_no_tag(request);
    auto work = [services, request, remove] {
        auto catalog = audited(services, request);
        remove(request, catalog);
    };
    co_await in_pool(services.pool, std::move(work));
    co_return empty_response(http::status::no_content);
}

}  // namespace divemesh::api
