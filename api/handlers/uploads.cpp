#include "api/handlers/uploads.hpp"

#include <boost/asio/steady_timer.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>

#include "api/audit.hpp"
#include "api/authorization.hpp"
#include "api/error_response.hpp"
#include "api/handlers/json_body.hpp"
#include "api/handlers/resource.hpp"
#include "api/in_pool.hpp"
#include "api/metrics.hpp"
#include "api/quota.hpp"
#include "api/uploads/concatenation.hpp"
#include "api/uploads/make_dive.hpp"
#include "api/uploads/make_truth.hpp"
#include "api/uploads/new_upload.hpp"
#include "api/uploads/receive_body.hpp"
#include "api/uploads/tus_headers.hpp"
#include "api/uploads/upload_metadata.hpp"
#include "api/uploads/upload_writer.hpp"
#include "api/visible.hpp"
#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "storage/dive_store.hpp"
#include "storage/upload_store.hpp"

namespace divemesh::api {
namespace {

constexpr auto kChecksumMismatch = static_cast<http::status>(460);
constexpr auto kNamingTimeout = std::chrono::seconds(2);

void check_content_length(const Request& request, const Upload& upload, const Services& services) {
    const std::int64_t room =
        upload.length_bytes.value_or(services.limits.max_upload_bytes) - upload.offset_bytes;
    if (request.stream->length_bytes().value_or(0) > room)
        throw Error(
            ErrorCode::TooLarge,
            "the body exceeds Upload-Length: only " + std::to_string(room) + " bytes are missing");
}

std::optional<UploadChecksum> checksum_of(const Request& request) {
    if (!request.has_header("upload-checksum")) return std::nullopt;
    return UploadChecksum(request.header("upload-checksum"));
}

bool becomes_dive(const Upload& upload) {
    return upload.complete() && !upload.is_partial() && plan_of(upload.metadata).commit;
}

// Does the same for truth.
Awaitable<Response> with_truth(
    Response response, Request request, Services services, Upload upload, StopFlag stopped) {
    const UploadPlan plan = plan_of(upload.metadata);
    const Token token = co_await authenticate(request, services, RouteKind::BodyStream);
    require_scope(token, "dives:write");
    const std::string sha256 = co_await hash_archive(services, upload, stopped);
    auto work = [services, request, upload, plan, sha256, num_bytes = response.uploaded_bytes] {
        auto catalog = audited(services, request, num_bytes);
        return make_truth(
            services, upload.dive_id.empty() ? catalog : services.catalog, upload, plan, sha256);
    };
    const TruthFile made = co_await in_pool(services.transfers, std::move(work));
    response.audited = upload.dive_id.empty();
    upload.expires_at_ms = 0;
    set_progress(response, upload);
    response.set("Divemesh-Truth", made.id);
    co_return response;
}

// The sender of the last byte has the dive made, so its token is checked again: it may have been
// revoked since the request began, or differ from that of the creation.
Awaitable<Response> with_dive(
    Response response, Request request, Services services, Upload upload, StopFlag stopped) {
    const UploadPlan plan = plan_of(upload.metadata);
    const Token token = co_await authenticate(request, services, RouteKind::BodyStream);
    require_scope(token, "dives:write");
    if (!plan.preset.empty()) require_scope(token, "jobs:write");
    const std::string sha256 = co_await hash_archive(services, upload, stopped);
    auto work = [services, request, upload, plan, sha256, num_bytes = response.uploaded_bytes] {
        auto catalog = audited(services, request, num_bytes);
        return make_dive(
            services, upload.dive_id.empty() ? catalog : services.catalog, upload, plan, sha256);
    };
    const MadeDive made = co_await in_pool(services.transfers, std::move(work));
    response.audited = upload.dive_id.empty();  // otherwise it was a dive before
    upload.expires_at_ms = 0;
    set_progress(response, upload);
    response.set("Divemesh-Dive", made.dive.id);
    if (!made.job_id.empty()) response.set("Divemesh-Job", made.job_id);
    co_return response;
}

// Completes the response to a request whose bytes all arrived.
Awaitable<Response> arrived(
    Response response, Request request, Services services, Upload upload, StopFlag stopped) {
    const bool is_truth = plan_of(upload.metadata).truth.has_value();
    if (becomes_dive(upload) && is_truth)
        co_return co_await with_truth(std::move(response), request, services, upload, stopped);
    if (becomes_dive(upload))
        co_return co_await with_dive(std::move(response), request, services, upload, stopped);
    set_progress(response, upload);
    co_return response;
}

// Does the same for the request that completed the upload. The audit log needs that event even if
// there is no dive of the upload.
Awaitable<Response> completed(
    Response response, Request request, Services services, Upload upload, StopFlag stopped) {
    response.uploaded_bytes = upload.offset_bytes;
    std::exception_ptr failure;
    try {
        co_return co_await arrived(std::move(response), request, services, upload, stopped);
    } catch (...) {
        failure = std::current_exception();
    }
    auto audit = [services, request, num_bytes = upload.offset_bytes] {
        audit_uploaded(services, request, num_bytes);
    };
    co_await in_pool(services.pool, std::move(audit));
    std::rethrow_exception(failure);
}

StopFlag new_flag() { return std::make_shared<std::atomic<bool>>(false); }

// Returns the function by which a newer request stops this one.
std::function<void()> stopper(const Request& request, const StopFlag& stopped) {
    return [stream = request.stream, stopped] {
        *stopped = true;
        stream->stop();
    };
}

Awaitable<UploadLocks::Lock> take_lock(Request request, Services services, StopFlag stopped) {
    // First checks that the upload exists, is visible and takes bytes if there are some: a bad
    // request must not stop another one.
    auto look = [services, request] {
        const Upload upload = visible_upload(request, services.catalog);
        if (upload.is_final() && request.method == verb::patch)
            throw Error(ErrorCode::Forbidden,
                        "a final upload takes only the bytes of its parts: send none");
    };
    co_await in_pool(services.pool, std::move(look));
    auto stop = stopper(request, stopped);
    co_return co_await services.locks.take(request.parameter("upload_id"), std::move(stop));
}

// Returns the response to a request whose checksum came as a trailer, which is not compared: a
// success would say that it was. The bytes are kept, as of every body without a checksum.
Response with_unread_trailer(const Request& request, const Response& response) {
    Response refused = problem_response(request,
                                        http::status::unsupported_media_type,
                                        "Upload-Checksum came as a trailer and was not compared; "
                                        "the bytes are kept: send it as a header");
    for (const auto& [name, value] : response.headers)
        if (name == "Upload-Offset" || name == "Location") refused.set(name, value);
    refused.uploaded_bytes = response.uploaded_bytes;
    refused.audited = response.audited;
    return refused;
}

// Returns the response to a request whose body is stored.
Awaitable<Response> stored(
    Response response, Request request, Services services, Upload upload, StopFlag stopped) {
    // The newer request wants the lock, and waits for it. So the dive is better made now than
    // never.
    if (upload.complete())
        co_return co_await completed(std::move(response), request, services, upload, new_flag());
    co_return co_await arrived(std::move(response), request, services, upload, stopped);
}

Awaitable<Response> receive(
    Response response, Request request, Services services, Upload upload, StopFlag stopped) {
    const auto received = co_await receive_body(request, services, upload, checksum_of(request));
    if (!received)
        co_return problem_response(
            request,
            kChecksumMismatch,
            "the bytes do not match Upload-Checksum and are not kept: send them again");
    response = co_await stored(std::move(response), request, services, *received, stopped);
    if (request.stream->has_trailer("upload-checksum"))
        co_return with_unread_trailer(request, response);
    co_return response;
}

// Checks that the dive of the truth exists and accepts it. Throws Error{NotFound}, Error{Conflict}.
void require_dive_of_truth(const Services& services, const Upload& wanted) {
    const UploadPlan plan = plan_of(wanted.metadata);
    if (!plan.truth) return;
    const Dive dive = storage::DiveStore(services.catalog).get(plan.dive_id);
    if (dive.project != wanted.project) throw Error(ErrorCode::NotFound, "no dive " + plan.dive_id);
    if (dive.state == DiveState::Refused || dive.deleted_at_ms > 0)
        throw Error(ErrorCode::Conflict, "dive " + dive.id + " was deleted or refused");
}

Response created(const Upload& upload) {
    Response response = empty_response(http::status::created);
    response.set("Location", "/api/v1/uploads/" + upload.id);
    return response;
}

Awaitable<Response> create_final(Request request, Services services, Upload wanted) {
    if (request.stream->length_bytes().value_or(1) > 0)
        throw Error(ErrorCode::InvalidArgument,
                    "a final upload has the bytes of its parts: send none with it");
    auto enter = [services, request, wanted] {
        require_dive_of_truth(services, wanted);
        auto catalog = audited(services, request);
        return enter_final(services, catalog, wanted);
    };
    Upload upload = co_await in_pool(services.pool, std::move(enter));
    const StopFlag stopped = new_flag();
    auto stop = [stopped] { *stopped = true; };
    auto lock = co_await services.locks.take(upload.id, std::move(stop));
    auto fresh = [services, upload] {
        Upload whole = reconciled(services, storage::UploadStore(services.catalog).get(upload.id));
        if (whole.complete()) free_parts(services, whole);  // left by a killed server
        return whole;
    };
    upload = co_await in_pool(services.pool, std::move(fresh));
    if (upload.complete())
        co_return co_await arrived(created(upload), request, services, upload, stopped);
    upload = co_await concatenate(services, upload, stopped);
    co_return co_await completed(created(upload), request, services, upload, stopped);
}

Response describe(const Upload& upload) {
    Response response = empty_response(http::status::ok);
    if (!upload.is_final() || upload.complete()) set_progress(response, upload);
    if (upload.length_bytes)
        response.set("Upload-Length", std::to_string(*upload.length_bytes));
    else
        response.set("Upload-Defer-Length", "1");
    if (!upload.metadata.empty()) response.set("Upload-Metadata", upload.metadata);
    if (!upload.concat.empty()) response.set("Upload-Concat", upload.concat);
    if (!upload.truth_id.empty())
        response.set("Divemesh-Truth", upload.truth_id);
    else if (!upload.dive_id.empty())
        response.set("Divemesh-Dive", upload.dive_id);
    response.set("Cache-Control", "no-store");
    return response;
}

// Waits until the upload's dive is made, which mostly takes moments. A client that lost the last
// response asks for the dive here.
Awaitable<Upload> once_named(Request request, Services services, Upload upload) {
    const auto end = std::chrono::steady_clock::now() + kNamingTimeout;
    boost::asio::steady_timer timer(co_await boost::asio::this_coro::executor);
    while (becomes_dive(upload) && upload.dive_id.empty() && upload.truth_id.empty() &&
           !services.stopping && std::chrono::steady_clock::now() < end) {
        timer.expires_after(std::chrono::milliseconds(50));
        co_await timer.async_wait(boost::asio::use_awaitable);
        auto look = [services, request] { return visible_upload(request, services.catalog); };
        upload = co_await in_pool(services.pool, std::move(look));
    }
    co_return upload;
}

Response offset_conflict(const Request& request, const Upload& upload) {
    Response response =
        problem_response(request,
                         http::status::conflict,
                         "the offset of this upload is " + std::to_string(upload.offset_bytes) +
                             ": ask for it with HEAD and send from there");
    response.set("Upload-Offset", std::to_string(upload.offset_bytes));
    return response;
}

// Returns the upload as it would be, because a refused request must not fix the length.
Upload with_deferred_length(const Request& request, Upload upload) {
    if (!upload.length_bytes && request.has_header("upload-length"))
        upload.length_bytes = std::max(count_header(request, "upload-length"), upload.offset_bytes);
    return upload;
}

// Sets the length that creation left open, if this request has it.
Upload with_length(const Request& request, const Services& services, const Upload& upload) {
    if (!request.has_header("upload-length")) {
        // Only the received bytes count; how many more will come is unknown.
        if (!upload.length_bytes) require_bytes_of_quota(services, upload.project, 1);
        return upload;
    }
    const std::int64_t length = count_header(request, "upload-length");
    if (length > services.limits.max_upload_bytes)
        throw Error(ErrorCode::TooLarge,
                    "an upload may have at most " +
                        std::to_string(services.limits.max_upload_bytes) + " bytes");
    return storage::UploadStore(services.catalog)
        .set_length(upload.id, length, services.limits.max_project_bytes);
}

}  // namespace

Awaitable<Response> describe_uploads(Request, Services services) {
    Response response = empty_response(http::status::no_content);
    response.set("Tus-Version", "1.0.0");
    response.set("Tus-Extension", kTusExtensions);
    response.set("Tus-Max-Size", std::to_string(services.limits.max_upload_bytes));
    response.set("Tus-Checksum-Algorithm", std::string(kChecksumAlgorithms));
    co_return response;
}

Awaitable<Response> create_upload(Request request, Services services) {
    if (auto refused = wrong_version(request)) co_return std::move(*refused);
    const Upload wanted = announced_upload(request, services.limits);
    if (!plan_of(wanted.metadata).preset.empty()) require_scope(request.token, "jobs:write");
    if (wanted.is_final()) co_return co_await create_final(request, services, wanted);
    if (wanted.length_bytes == 0 && plan_of(wanted.metadata).commit)
        throw Error(ErrorCode::BadData, "the upload is empty: send at least one byte");
    const bool with_bytes = brings_bytes(request);
    checksum_of(request);
    if (with_bytes) check_content_length(request, wanted, services);
    if (!with_bytes && request.stream->length_bytes().value_or(1) > 0) require_bytes(request);
    auto enter = [services, request, wanted] {
        require_dive_of_truth(services, wanted);
        auto catalog = audited(services, request);
        return enter_upload(services, catalog, wanted);
    };
    const Upload upload = co_await in_pool(services.pool, std::move(enter));
    const StopFlag stopped = new_flag();
    auto stop = stopper(request, stopped);
    auto lock = co_await services.locks.take(upload.id, std::move(stop));
    if (with_bytes) co_return co_await receive(created(upload), request, services, upload, stopped);
    co_return co_await arrived(created(upload), request, services, upload, stopped);
}

Awaitable<Response> get_upload_offset(Request request, Services services) {
    if (auto refused = wrong_version(request)) co_return std::move(*refused);
    auto look = [services, request] { return visible_upload(request, services.catalog); };
    Upload upload = co_await in_pool(services.pool, std::move(look));
    // The concatenation of parts and the hashing of a complete upload must not be stopped.
    if (upload.is_final()) co_return describe(upload);
    if (upload.complete()) co_return describe(co_await once_named(request, services, upload));
    auto lock = co_await take_lock(request, services, new_flag());
    auto fresh = [services, request] {
        return reconciled(services, visible_upload(request, services.catalog));
    };
    upload = co_await in_pool(services.pool, std::move(fresh));
    if (upload.offset_bytes > 0 && !upload.complete())
        services.metrics.resumed_bytes.observe(static_cast<double>(upload.offset_bytes));
    co_return describe(upload);
}

Awaitable<Response> get_upload(Request request, Services services) {
    return get_resource(std::move(request), services, visible_upload);
}

Awaitable<Response> append_to_upload(Request request, Services services) {
    if (auto refused = wrong_version(request)) co_return std::move(*refused);
    require_bytes(request);
    const std::int64_t offset = count_header(request, "upload-offset");
    checksum_of(request);
    const StopFlag stopped = new_flag();
    auto lock = co_await take_lock(request, services, stopped);
    auto fresh = [services, request] {
        return reconciled(services, visible_upload(request, services.catalog));
    };
    Upload upload = co_await in_pool(services.pool, std::move(fresh));
    if (offset != upload.offset_bytes) co_return offset_conflict(request, upload);
    check_content_length(request, with_deferred_length(request, upload), services);
    auto lengthen = [services, request, upload] { return with_length(request, services, upload); };
    upload = co_await in_pool(services.pool, std::move(lengthen));
    Response response = empty_response(http::status::no_content);
    if (upload.complete())
        co_return co_await arrived(std::move(response), request, services, upload, stopped);
    co_return co_await receive(std::move(response), request, services, upload, stopped);
}

Awaitable<Response> terminate_upload(Request request, Services services) {
    if (auto refused = wrong_version(request)) co_return std::move(*refused);
    auto lock = co_await take_lock(request, services, new_flag());
    auto work = [services, request] {
        const Upload upload = visible_upload(request, services.catalog);
        auto catalog = audited(services, request);
        storage::UploadStore(catalog).end(upload.id, UploadEnd::Terminated);
        free_bytes(services, upload);
    };
    co_await in_pool(services.pool, std::move(work));
    co_return empty_response(http::status::no_content);
}

}  // namespace divemesh::api
