#include "api/handlers/jobs.hpp"

#include <algorithm>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>
#include <limits>
#include <utility>

#include "api/audit.hpp"
#include "api/authorization.hpp"
#include "api/disk_guard.hpp"
#include "api/handlers/json_body.hpp"
#include "api/handlers/resource.hpp"
#include "api/handlers/shown_jobs.hpp"
#include "api/idempotency.hpp"
#include "api/in_pool.hpp"
#include "api/job_options.hpp"
#include "api/quota.hpp"
#include "api/target.hpp"
#include "api/visible.hpp"
#include "schemas/json.hpp"
#include "schemas/reconstruction_options.hpp"
#include "storage/job_store.hpp"

namespace divemesh::api {
namespace {

constexpr std::chrono::seconds kMaxWait{60};
constexpr std::chrono::milliseconds kLookEvery{200};

storage::JobFilter filter_of(const Request& request) {
    storage::JobFilter filter{visible_project(request.token), query_value(request, "dive_id")};
    const std::string state = query_value(request, "state");
    if (!state.empty()) filter.state = job_state_from_string(state);
    const std::string kind = query_value(request, "kind");
    if (!kind.empty()) filter.kind = job_kind_from_string(kind);
    filter.deleted = flag_value(request, "deleted");
    filter.created_after_ms = time_value(request, "created_after_ms", filter.created_after_ms);
    filter.created_before_ms = time_value(request, "created_before_ms", filter.created_before_ms);
    return filter;
}

// Checks a comparison requested from its earlier dive: "with" is the later one.
void check_options(storage::NewJob& job) {
    switch (job.kind) {
        case JobKind::Reconstruct: make_options(job.preset, job.options); return;
        case JobKind::Compare: check_compare_options(job.options); break;
        case JobKind::AccuracyReport: check_report_options(job.options); break;
        case JobKind::Intake: break;  // refused by kind_of()
    }
    if (job.options.value("fresh", false)) job.fresh_version = DIVEMESH_VERSION;
    job.options.erase("fresh");
}

// Calls `read` and adds to its error where in the body the fault is.
template <typename Read>
auto at_pointer(const std::string& pointer, const Read& read) {
    try {
        return read();
    } catch (const InvalidInput& error) {
        throw error.below(pointer);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::InvalidArgument) throw;
        throw InvalidInput({{error.what(), pointer, ""}});
    }
}

JobKind kind_of(const std::string& name) {
    const JobKind kind = job_kind_from_string(name);
    if (kind == JobKind::Intake)
        throw Error(ErrorCode::InvalidArgument, "an intake job is created only with its dive");
    return kind;
}

storage::NewJob job_request(const Request& request, const Dive& dive) {
    const auto body = json_body(request, {"kind", "preset", "options", "priority", "parents"});
    storage::NewJob job;
    job.project = dive.project;
    job.dive_id = dive.id;
    const auto kind = value_or<std::string>(body, "kind", "reconstruct");
    job.kind = at_pointer("/kind", [&] { return kind_of(kind); });
    job.preset = value_or<std::string>(body, "preset", "standard");
    at_pointer("/preset", [&] { return preset_options(job.preset); });
    job.options = body.value("options", nlohmann::json::object());
    at_pointer("/options", [&] { check_options(job); });
    job.parents = value_or<std::vector<std::string>>(body, "parents", {});
    job.priority = value_or<int>(body, "priority", 0);
    job.request_key = request_key(request);
    return job;
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

std::chrono::seconds wait_of(const Request& request) {
    if (!request.query.contains("wait")) return {};
    const auto seconds = parse_count(query_value(request, "wait"));
    if (!seconds || *seconds > kMaxWait.count())
        throw InvalidInput(
            {{"wait must be 0 to " + std::to_string(kMaxWait.count()) + " seconds", "", "wait"}});
    return std::chrono::seconds(*seconds);
}

Awaitable<JobState> state_of_job(Request request, Services services) {
    auto look = [request](storage::Catalog& catalog) {
        return visible_job(request, catalog).state;
    };
    return read_nonblocking(services, std::move(look));
}

// Returns when the job's state has changed or cannot change any more, after `wait`, or when the
// server stops. No thread waits meanwhile.
Awaitable<void> wait_for_change(Request request, Services services, std::chrono::seconds wait) {
    const auto end = std::chrono::steady_clock::now() + wait;
    boost::asio::steady_timer timer(co_await boost::asio::this_coro::executor);
    const JobState before = co_await state_of_job(request, services);
    JobState state = before;
    while (state == before && !is_finished(state) && !services.stopping &&
           std::chrono::steady_clock::now() < end) {
        timer.expires_at(std::min(end, std::chrono::steady_clock::now() + kLookEvery));
        co_await timer.async_wait(boost::asio::use_awaitable);
        state = co_await state_of_job(request, services);
    }
}

// Returns the text from ?from= on; nothing beyond its end.
Response text_response(const Request& request, std::string text) {
    const auto from =
        request.query.contains("from") ? parse_count(query_value(request, "from")) : 0;
    if (!from) throw InvalidInput({{"from must be a number of bytes", "", "from"}});
    text.erase(0, static_cast<std::size_t>(*from));
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
        storage::Page<ShownJob> page{.items = {}, .next_cursor = std::move(jobs.next_cursor)};
        for (Job& job : jobs.items) {
            page.items.push_back(with_forecast(std::move(job), services, catalog));
            if (filter.deleted) add_deletion(page.items.back(), catalog);
        }
        return page;
    };
    return get_page(std::move(request), services, read);
}

Awaitable<Response> create_job(Request request, Services services) {
    auto work = [services, request] {
        require_room(services);
        const Dive dive = visible_dive(request, services.catalog);
        require_bytes_of_quota(services, dive.project, 0);
        auto catalog = audited(services, request);
        auto made = storage::JobStore(catalog).enqueue(job_request(request, dive));
        return std::pair(shown_job(std::move(made.job), services, services.catalog), made.is_new);
    };
    const auto [job, is_new] = co_await in_pool(services.pool, std::move(work));
    Response response = json_response(is_new ? http::status::created : http::status::ok, job);
    response.set("Location", "/api/v1/jobs/" + job.id);
    co_return response;
}

Awaitable<Response> get_job(Request request, Services services) {
    const std::chrono::seconds wait = wait_of(request);
    if (wait.count() > 0) co_await wait_for_change(request, services, wait);
    auto read = [services](const Request& asked, storage::Catalog& catalog) {
        return shown_job(asked, services, catalog);
    };
    co_return co_await get_resource(std::move(request), services, read);
}

Awaitable<Response> change_job(Request request, Services services) {
    auto change = [services](const Request& asked) {
        const std::string id = visible_job(asked, services.catalog).id;
        auto catalog = audited_if_job_matches(services, asked);
        Job job = storage::JobStore(catalog).change(id, job_change(asked));
        return shown_job(std::move(job), services, services.catalog);
    };
    return change_resource(std::move(request), services, change);
}

Awaitable<Response> cancel_job(Request request, Services services) {
    auto cancel = [services](const Request& asked) {
        auto catalog = audited_if_job_matches(services, asked);
        Job job = storage::JobStore(catalog).cancel(visible_job(asked, catalog).id);
        return shown_job(std::move(job), services, services.catalog);
    };
    return change_resource(std::move(request), services, cancel);
}

Awaitable<Response> retry_job(Request request, Services services) {
    auto retry = [services](const Request& asked) {
        require_room(services);
        const Job job = visible_job(asked, services.catalog);
        require_bytes_of_quota(services, job.project, 0);
        auto catalog = audited_if_job_matches(services, asked);
        Job retried = storage::JobStore(catalog).retry(job.id);
        return shown_job(std::move(retried), services, services.catalog);
    };
    return change_resource(std::move(request), services, retry);
}

Awaitable<Response> get_job_log(Request request, Services services) {
    auto work = [services, request] {
        return storage::JobStore(services.catalog).log(visible_job(request, services.catalog).id);
    };
    co_return text_response(request, co_await in_pool(services.pool, std::move(work)));
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
    co_return text_response(request, co_await in_pool(services.pool, std::move(work)));
}

Awaitable<Response> list_artifacts(Request request, Services services) {
    auto read = [](const Request& asked, storage::Catalog& catalog) {
        return storage::JobStore(catalog).artifacts(visible_job(asked, catalog).id);
    };
    return get_list(std::move(request), services, read);
}

}  // namespace divemesh::api
