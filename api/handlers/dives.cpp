#include "api/handlers/dives.hpp"

#include "api/audit.hpp"
#include "api/authorization.hpp"
#include "api/handlers/json_body.hpp"
#include "api/handlers/resource.hpp"
#include "api/in_pool.hpp"
#include "api/target.hpp"
#include "api/uploads/make_dive.hpp"
#include "api/uploads/upload_metadata.hpp"
#include "api/uploads/upload_writer.hpp"
#include "api/visible.hpp"
#include "schemas/json.hpp"
#include "schemas/reconstruction_options.hpp"
#include "storage/dive_store.hpp"

namespace divemesh::api {
namespace {

constexpr std::size_t kMaxNameBytes = 200;

storage::DiveFilter filter_of(const Request& request) {
    storage::DiveFilter filter{visible_project(request.token),
                               query_value(request, "content_sha256"),
                               query_value(request, "archive_sha256"),
                               query_value(request, "site")};
    filter.tag = query_value(request, "tag");
    filter.deleted = flag_value(request, "deleted");
    filter.created_after_ms = time_value(request, "created_after_ms", filter.created_after_ms);
    filter.created_before_ms = time_value(request, "created_before_ms", filter.created_before_ms);
    if (!filter.content_sha256.empty()) check_sha256(filter.content_sha256, "content_sha256");
    if (!filter.archive_sha256.empty()) check_sha256(filter.archive_sha256, "archive_sha256");
    const std::string state = query_value(request, "state");
    if (!state.empty()) filter.state = dive_state_from_string(state);
    return filter;
}

struct DiveRequest {
    std::string upload_id;
    std::string name;
    std::string preset;
};

DiveRequest dive_request(const Request& request) {
    const auto body = json_body(request, {"upload_id", "name", "job"});
    DiveRequest wanted{value_or<std::string>(body, "upload_id", ""),
                       value_or<std::string>(body, "name", ""),
                       value_or<std::string>(body, "job", "")};
    if (wanted.upload_id.empty())
        throw Error(ErrorCode::InvalidArgument,
                    "\"upload_id\" is missing: give the id of the upload");
    if (wanted.name.size() > kMaxNameBytes)
        throw Error(ErrorCode::InvalidArgument, "\"name\" is longer than 200 bytes");
    if (body.contains("job")) {
        preset_options(wanted.preset);
        require_scope(request.token, "jobs:write");
    }
    return wanted;
}

// Shows a sharing link nothing of what people note about a dive for themselves.
Dive shown_dive(const Request& request, storage::Catalog& catalog) {
    Dive dive = visible_dive(request, catalog);
    if (request.token.shared_job.empty()) return dive;
    dive.notes.clear();
    dive.position.reset();
    dive.recorded = nlohmann::json::object();
    return dive;
}

}  // namespace

Awaitable<Response> list_dives(Request request, Services services) {
    auto read = [](const Request& asked, storage::Catalog& catalog) {
        const auto filter = filter_of(asked);
        return storage::DiveStore(catalog).list(filter, page_request(asked));
    };
    return get_page(std::move(request), services, read);
}

Awaitable<Response> create_dive(Request request, Services services) {
    const DiveRequest wanted = dive_request(request);
    request.parameters.emplace("upload_id", wanted.upload_id);
    auto look = [services, request] { visible_upload(request, services.catalog); };
    co_await in_pool(services.pool, std::move(look));
    const StopFlag stopped = std::make_shared<std::atomic<bool>>(false);
    auto stop = [stopped] { *stopped = true; };
    auto lock = co_await services.locks.take(wanted.upload_id, std::move(stop));
    auto fresh = [services, request] {
        return reconciled(services, visible_upload(request, services.catalog));
    };
    const Upload upload = co_await in_pool(services.pool, std::move(fresh));
    UploadPlan plan = plan_of(upload.metadata);
    if (plan.truth)
        throw Error(ErrorCode::Conflict, "upload " + upload.id + " is a truth file, not a dive");
    if (!wanted.name.empty()) plan.name = wanted.name;
    if (!wanted.preset.empty()) plan.preset = wanted.preset;
    if (!plan.preset.empty()) require_scope(request.token, "jobs:write");
    const std::string sha256 = co_await hash_archive(services, upload, stopped);
    auto work = [services, upload, plan, sha256, request] {
        auto catalog = audited(services, request);
        return make_dive(services, catalog, upload, plan, sha256);
    };
    const MadeDive made = co_await in_pool(services.transfers, std::move(work));
    Response response =
        json_response(made.is_new ? http::status::created : http::status::ok, made.dive);
    response.set("Location", "/api/v1/dives/" + made.dive.id);
    if (!made.job_id.empty()) response.set("Divemesh-Job", made.job_id);
    co_return response;
}

Awaitable<Response> get_dive(Request request, Services services) {
    return get_resource(std::move(request), services, shown_dive);
}

Awaitable<Response> list_findings(Request request, Services services) {
    auto read = [](const Request& asked, storage::Catalog& catalog) {
        return storage::DiveStore(catalog).findings(visible_dive(asked, catalog).id);
    };
    return get_list(std::move(request), services, read);
}

}  // namespace divemesh::api
