#include "api/handlers/jobs.hpp"

#include "api/authorization.hpp"
#include "api/handlers/json_body.hpp"
#include "api/in_pool.hpp"
#include "api/visible.hpp"
#include "schemas/json.hpp"
#include "storage/job_store.hpp"

namespace divemesh::api {
namespace {

storage::JobFilter filter_of(const Request& request) {
    storage::JobFilter filter{visible_project(request.token), query_value(request, "dive_id")};
    const std::string state = query_value(request, "state");
    if (!state.empty()) filter.state = job_state_from_string(state);
    const std::string kind = query_value(request, "kind");
    if (!kind.empty()) filter.kind = job_kind_from_string(kind);
    return filter;
}

}  // namespace

Awaitable<Response> list_jobs(Request request, Services services) {
    const auto filter = filter_of(request);
    const auto page = page_request(request);
    auto work = [&catalog = services.catalog, filter, page] {
        return storage::JobStore(catalog).list(filter, page);
    };
    const auto jobs = co_await in_pool(services.pool, std::move(work));
    co_return list_response(request, jobs.items, jobs.next_cursor);
}

Awaitable<Response> get_job(Request request, Services services) {
    auto work = [services, request] { return visible_job(request, services); };
    const Job job = co_await in_pool(services.pool, std::move(work));
    co_return json_response(http::status::ok, job);
}

Awaitable<Response> cancel_job(Request request, Services services) {
    auto work = [services, request] {
        return storage::JobStore(services.catalog).cancel(visible_job(request, services).id);
    };
    const Job job = co_await in_pool(services.pool, std::move(work));
    co_return json_response(http::status::ok, job);
}

Awaitable<Response> retry_job(Request request, Services services) {
    auto work = [services, request] {
        return storage::JobStore(services.catalog).retry(visible_job(request, services).id);
    };
    const Job job = co_await in_pool(services.pool, std::move(work));
    co_return json_response(http::status::ok, job);
}

Awaitable<Response> get_job_log(Request request, Services services) {
    auto work = [services, request] {
        return storage::JobStore(services.catalog).log(visible_job(request, services).id);
    };
    Response response = empty_response(http::status::ok);
    response.body = co_await in_pool(services.pool, std::move(work));
    response.set("Content-Type", "text/plain; charset=utf-8");
    co_return response;
}

Awaitable<Response> list_artifacts(Request request, Services services) {
    auto work = [services, request] {
        return storage::JobStore(services.catalog).artifacts(visible_job(request, services).id);
    };
    const auto artifacts = co_await in_pool(services.pool, std::move(work));
    co_return list_response(request, artifacts);
}

}  // namespace divemesh::api
