#include "api/handlers/jobs.hpp"

#include <limits>

#include "api/authorization.hpp"
#include "api/disk_guard.hpp"
#include "api/handlers/json_body.hpp"
#include "api/handlers/resource.hpp"
#include "api/in_pool.hpp"
#include "api/preconditions.hpp"
#include "api/target.hpp"
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
    filter.created_after_ms = time_value(request, "created_after_ms", filter.created_after_ms);
    filter.created_before_ms = time_value(request, "created_before_ms", filter.created_before_ms);
    return filter;
}

storage::JobChange job_change(const Request& request) {
    const auto body = json_body(request, {"priority", "paused"});
    storage::JobChange change;
    if (body.contains("priority")) change.priority = value_or<int>(body, "priority", 0);
    if (body.contains("paused")) change.paused = value_or<bool>(body, "paused", false);
    return change;
}

int attempt_number(const Request& request) {
    const auto number = parse_count(request.parameter("attempt"));
    if (!number || *number > std::numeric_limits<int>::max())
        throw Error(ErrorCode::NotFound, "no such attempt");
    return static_cast<int>(*number);
}

// Returns the job as GET shows it.
Job shown_job(const Request& request, const Services& services, storage::Catalog& catalog) {
    Job job = visible_job(request, catalog);
    job.forecast = services.forecast.of(job, catalog);
    return job;
}

storage::Catalog audited_if_match(const Services& services, const Request& request) {
    return audited_if_match(services, request, [services, request] {
        return shown_job(request, services, services.catalog);
    });
}

Response text_response(std::string text) {
    Response response = empty_response(http::status::ok);
    response.body = std::move(text);
    response.set("Content-Type", "text/plain; charset=utf-8");
    return response;
}

}  // namespace

Awaitable<Response> list_jobs(Request request, Services services) {
    auto read = [services](const Request& asked, storage::Catalog& catalog) {
        const auto filter = filter_of(asked);
        auto jobs = storage::JobStore(catalog).list(filter, page_request(asked));
        for (Job& job : jobs.items) job.forecast = services.forecast.of(job, catalog);
        return jobs;
    };
    return get_page(std::move(request), services, read);
}

Awaitable<Response> get_job(Request request, Services services) {
    auto read = [services](const Request& asked, storage::Catalog& catalog) {
        return shown_job(asked, services, catalog);
    };
    return get_resource(std::move(request), services, read);
}

Awaitable<Response> change_job(Request request, Services services) {
    auto work = [services, request] {
        const std::string id = visible_job(request, services.catalog).id;
        auto catalog = audited_if_match(services, request);
        return storage::JobStore(catalog).change(id, job_change(request));
    };
    const Job job = co_await in_pool(services.pool, std::move(work));
    co_return json_response(http::status::ok, job);
}

Awaitable<Response> cancel_job(Request request, Services services) {
    auto work = [services, request] {
        auto catalog = audited_if_match(services, request);
        return storage::JobStore(catalog).cancel(visible_job(request, catalog).id);
    };
    const Job job = co_await in_pool(services.pool, std::move(work));
    co_return json_response(http::status::ok, job);
}

Awaitable<Response> retry_job(Request request, Services services) {
    auto work = [services, request] {
        require_room(services);
        auto catalog = audited_if_match(services, request);
        return storage::JobStore(catalog).retry(visible_job(request, catalog).id);
    };
    const Job job = co_await in_pool(services.pool, std::move(work));
    co_return json_response(http::status::ok, job);
}

Awaitable<Response> get_job_log(Request request, Services services) {
    auto work = [services, request] {
        return storage::JobStore(services.catalog).log(visible_job(request, services.catalog).id);
    };
    co_return text_response(co_await in_pool(services.pool, std::move(work)));
}

Awaitable<Response> list_attempts(Request request, Services services) {
    auto read = [](const Request& asked, storage::Catalog& catalog) {
        return storage::JobStore(catalog).attempts(visible_job(asked, catalog).id);
    };
    return get_list(std::move(request), services, read);
}

Awaitable<Response> get_attempt_log(Request request, Services services) {
    auto work = [services, request, attempt = attempt_number(request)] {
        const std::string id = visible_job(request, services.catalog).id;
        return storage::JobStore(services.catalog).log(id, attempt);
    };
    co_return text_response(co_await in_pool(services.pool, std::move(work)));
}

Awaitable<Response> list_artifacts(Request request, Services services) {
    auto read = [](const Request& asked, storage::Catalog& catalog) {
        return storage::JobStore(catalog).artifacts(visible_job(asked, catalog).id);
    };
    return get_list(std::move(request), services, read);
}

}  // namespace divemesh::api
