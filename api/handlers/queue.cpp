#include "api/handlers/queue.hpp"

#include "api/authorization.hpp"
#include "api/disk_guard.hpp"
#include "api/handlers/json_body.hpp"
#include "api/handlers/resource.hpp"
#include "api/handlers/shown_jobs.hpp"
#include "api/in_pool.hpp"
#include "api/preconditions.hpp"
#include "schemas/json.hpp"
#include "storage/job_store.hpp"
#include "storage/project_usage.hpp"
#include "storage/queue_store.hpp"
#include "storage/worker_store.hpp"

namespace divemesh::api {
namespace {

constexpr std::size_t kMaxProjectBytes = 63;

// Returns the project of a request. An administrator names one, "" for all; other callers have
// their own.
std::string project_of(const Request& request, const std::string& wanted) {
    if (wanted.size() > kMaxProjectBytes)
        throw Error(ErrorCode::InvalidArgument, "\"project\" is longer than 63 bytes");
    std::string visible = visible_project(request.token);
    if (visible.empty()) return wanted;
    require_visible(request.token, wanted.empty() ? visible : wanted, "project " + wanted);
    return visible;
}

storage::Catalog audited_if_queue_matches(const Services& services,
                                          const Request& request,
                                          const std::string& project) {
    return audited_if_match(services, request, [&catalog = services.catalog, project] {
        return storage::QueueStore(catalog).get(project);
    });
}

}  // namespace

Awaitable<Response> get_queue(Request request, Services services) {
    const std::string project = project_of(request, query_value(request, "project"));
    auto work = [&catalog = services.catalog, project] {
        return storage::QueueStore(catalog).get(project);
    };
    const Queue queue = co_await in_pool(services.pool, std::move(work));
    co_return resource_response(request, queue);
}

// A "max_" of 0 means no limit.
Awaitable<Response> get_usage(Request request, Services services) {
    const std::string project = project_of(request, query_value(request, "project"));
    auto work = [&catalog = services.catalog, project] {
        return storage::read_usage(catalog, project);
    };
    const auto usage = co_await in_pool(services.pool, std::move(work));
    const nlohmann::json body = {{"project", project},
                                 {"num_dives", usage.num_dives},
                                 {"max_dives", services.limits.max_project_dives},
                                 {"stored_bytes", usage.stored_bytes},
                                 {"max_bytes", services.limits.max_project_bytes}};
    co_return json_response(http::status::ok, body);
}

Awaitable<Response> change_queue(Request request, Services services) {
    const auto body = json_body(request, {"project", "paused", "max_running", "keep_results"});
    const std::string project = project_of(request, value_or<std::string>(body, "project", ""));
    storage::QueueChange change;
    if (body.contains("paused")) change.paused = value_or<bool>(body, "paused", false);
    if (body.contains("max_running")) change.max_running = value_or<int>(body, "max_running", 0);
    if (body.contains("keep_results")) change.keep_results = value_or<int>(body, "keep_results", 0);
    auto apply = [services, project, change](const Request& asked) {
        auto catalog = audited_if_queue_matches(services, asked, project);
        return storage::QueueStore(catalog).change(project, change);
    };
    return change_resource(std::move(request), services, apply);
}

Awaitable<Response> redrive_queue(Request request, Services services) {
    const auto body = json_body(request, {"project", "limit"});
    const std::string project = project_of(request, value_or<std::string>(body, "project", ""));
    const int limit = value_or<int>(body, "limit", 100);
    auto work = [services, request, project, limit] {
        require_room(services);
        auto catalog = audited_if_queue_matches(services, request, project);
        std::vector<ShownJob> shown;
        for (Job& job :
             storage::JobStore(catalog).redrive(project, limit, services.limits.max_project_bytes))
            shown.push_back(shown_job(std::move(job), services, services.catalog));
        return shown;
    };
    const auto jobs = co_await in_pool(services.pool, std::move(work));
    co_return whole_list_response(request, jobs);
}

Awaitable<Response> list_workers(Request request, Services services) {
    auto read = [](const Request&, storage::Catalog& catalog) {
        return storage::WorkerStore(catalog).list();
    };
    return get_list(std::move(request), services, read);
}

Awaitable<Response> get_worker(Request request, Services services) {
    auto read = [](const Request& asked, storage::Catalog& catalog) {
        return storage::WorkerStore(catalog).get(asked.parameter("worker_name"));
    };
    return get_resource(std::move(request), services, read);
}

Awaitable<Response> change_worker(Request request, Services services) {
    auto change = [services](const Request& asked) {
        const std::string& name = asked.parameter("worker_name");
        auto catalog = audited_if_match(services, asked, [&all = services.catalog, name] {
            return storage::WorkerStore(all).get(name);
        });
        storage::WorkerStore workers(catalog);
        workers.get(name);
        const auto body = json_body(asked, {"draining"});
        if (!body.contains("draining"))
            throw Error(ErrorCode::InvalidArgument, "\"draining\" is missing: give true or false");
        return workers.set_draining(name, value_or<bool>(body, "draining", false));
    };
    return change_resource(std::move(request), services, change);
}

}  // namespace divemesh::api
