#include "api/handlers/schedules.hpp"

#include "api/audit.hpp"
#include "api/authorization.hpp"
#include "api/handlers/json_body.hpp"
#include "api/handlers/resource.hpp"
#include "api/in_pool.hpp"
#include "api/job_options.hpp"
#include "api/visible.hpp"
#include "schemas/json.hpp"
#include "schemas/reconstruction_options.hpp"
#include "storage/schedule_store.hpp"

namespace divemesh::api {
namespace {

constexpr std::size_t kMaxTagBytes = 200;

Schedule schedule_request(const Request& request) {
    const auto body = json_body(request, {"cron", "tag", "preset", "options"});
    Schedule wanted;
    wanted.project = request.token.project;
    wanted.cron = value_or<std::string>(body, "cron", "");
    wanted.tag = value_or<std::string>(body, "tag", "");
    wanted.preset = value_or<std::string>(body, "preset", "standard");
    wanted.options = body.value("options", nlohmann::json::object());
    if (wanted.tag.empty() || wanted.tag.size() > kMaxTagBytes)
        throw InvalidInput(
            {{"\"tag\" is missing: give the tag of the dives to report on", "/tag", ""}});
    preset_options(wanted.preset);
    try {
        check_scheduled_options(wanted.options);
    } catch (const InvalidInput& error) {
        throw error.below("/options");
    }
    return wanted;
}

}  // namespace

Awaitable<Response> list_schedules(Request request, Services services) {
    auto read = [](const Request& asked, storage::Catalog& catalog) {
        return storage::ScheduleStore(catalog).list(visible_project(asked.token),
                                                    page_request(asked));
    };
    return get_page(std::move(request), services, read);
}

Awaitable<Response> create_schedule(Request request, Services services) {
    auto work = [services, request] {
        const Schedule wanted = schedule_request(request);
        auto catalog = audited(services, request);
        return storage::ScheduleStore(catalog).create(wanted);
    };
    const Schedule made = co_await in_pool(services.pool, std::move(work));
    Response response = json_response(http::status::created, made);
    response.set("Location", "/api/v1/schedules/" + made.id);
    co_return response;
}

Awaitable<Response> get_schedule(Request request, Services services) {
    return get_resource(std::move(request), services, visible_schedule);
}

Awaitable<Response> delete_schedule(Request request, Services services) {
    auto remove = [](const Request& asked, storage::Catalog& catalog) {
        storage::ScheduleStore(catalog).remove(visible_schedule(asked, catalog).id);
    };
    return delete_resource(std::move(request), services, visible_schedule, remove);
}

}  // namespace divemesh::api
