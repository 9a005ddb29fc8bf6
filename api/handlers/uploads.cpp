#include "api/handlers/uploads.hpp"

#include <algorithm>
#include <vector>

#include "api/authorization.hpp"
#include "api/error_response.hpp"
#include "api/in_pool.hpp"
#include "api/make_dive.hpp"
#include "api/target.hpp"
#include "api/upload_metadata.hpp"
#include "api/upload_writer.hpp"
#include "api/visible.hpp"
#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "storage/upload_store.hpp"

namespace divemesh::api {
namespace {

constexpr std::size_t kChunkBytes = std::size_t{256} << 10;
constexpr std::size_t kMaxMetadataBytes = 8192;
constexpr const char* kBytesType = "application/offset+octet-stream";

// tus 1.0: every request names its version, or is not processed.
std::optional<Response> wrong_version(const Request& request) {
    if (request.header("tus-resumable") == "1.0.0") return std::nullopt;
    Response response = problem_response(
        request, http::status::precondition_failed, "send Tus-Resumable: 1.0.0 with the request");
    response.set("Tus-Version", "1.0.0");
    return response;
}

std::int64_t count_header(const Request& request, const std::string& name) {
    const auto value = parse_count(request.header(name));
    if (!value) throw Error(ErrorCode::InvalidArgument, name + " has to be a number of bytes");
    return *value;
}

// What creation checks before anything is stored.
Upload announced_upload(const Request& request, const Services& services) {
    if (request.has_header("upload-defer-length"))
        throw Error(ErrorCode::InvalidArgument, "state the whole length as Upload-Length");
    Upload upload;
    upload.project = request.token.project;
    upload.length_bytes = count_header(request, "upload-length");
    if (upload.length_bytes > services.limits.max_upload_bytes)
        throw Error(
            ErrorCode::TooLarge,
            "an upload has at most " + std::to_string(services.limits.max_upload_bytes) + " bytes");
    upload.metadata = request.header("upload-metadata");
    if (upload.metadata.size() > kMaxMetadataBytes)
        throw Error(ErrorCode::InvalidArgument, "Upload-Metadata is longer than 8192 bytes");
    const UploadPlan plan = plan_of(upload.metadata);
    if (!plan.preset.empty()) require_scope(request.token, "jobs:write");
    return upload;
}

Upload enter_upload(const Services& services, const Upload& upload) {
    const std::int64_t free_bytes = services.blobs.free_bytes();
    if (upload.length_bytes > free_bytes - services.limits.min_free_bytes)
        throw Error(
            ErrorCode::OutOfSpace,
            "the server's disk has no room for " + std::to_string(upload.length_bytes) + " bytes");
    return storage::UploadStore(services.catalog).create(upload);
}

bool brings_bytes(const Request& request) { return request.header("content-type") == kBytesType; }

void check_content_length(const Request& request, const Upload& upload) {
    const std::int64_t room = upload.length_bytes - upload.offset_bytes;
    if (request.stream->length_bytes().value_or(0) > room)
        throw Error(
            ErrorCode::TooLarge,
            "the body goes past Upload-Length: " + std::to_string(room) + " bytes are missing");
}

struct Appended {
    Upload upload;
    BodyRead::State ended = BodyRead::State::End;
    bool too_long = false;
};

// Streams the body to disk until it ends, whatever the reason; every byte that came is durable
// when this returns or throws.
Awaitable<Appended> append_body(std::shared_ptr<BodyStream> stream,
                                Services services,
                                std::shared_ptr<UploadWriter> writer) {
    Appended result;
    std::exception_ptr failure;
    std::vector<char> buffer(kChunkBytes);
    try {
        for (bool more = true; more;) {
            const BodyRead read = co_await stream->read(buffer);
            const auto room = static_cast<std::size_t>(writer->room_bytes());
            result.too_long = read.num_bytes > room;
            result.ended = read.state;
            more = read.state == BodyRead::State::More && !result.too_long;
            if (read.num_bytes == 0) continue;
            const std::span<const char> bytes(buffer.data(), std::min(read.num_bytes, room));
            auto write = [writer, bytes] { writer->write(bytes); };
            co_await in_pool(services.pool, std::move(write));
        }
    } catch (...) {
        failure = std::current_exception();
    }
    auto finish = [writer] { return writer->finish(); };
    result.upload = co_await in_pool(services.pool, std::move(finish));
    if (failure) std::rethrow_exception(failure);
    co_return result;
}

void throw_unless_whole(const Appended& appended) {
    if (appended.too_long)
        throw Error(ErrorCode::TooLarge, "the body went past Upload-Length: the rest is not kept");
    if (appended.ended == BodyRead::State::Stopped)
        throw Error(ErrorCode::Conflict,
                    "a newer request took this upload over, or the server stops");
    if (appended.ended == BodyRead::State::Lost)
        throw Error(ErrorCode::Unavailable, "the body did not arrive: HEAD tells what did");
}

// The response with the dive that the upload became, when it is complete and asked for one.
Awaitable<Response> with_dive(Response response, Upload upload, Services services) {
    const UploadPlan plan = plan_of(upload.metadata);
    if (!plan.commit || !upload.complete()) co_return response;
    auto work = [services, upload, plan] { return make_dive(services, upload, plan); };
    const MadeDive made = co_await in_pool(services.pool, std::move(work));
    response.set("Divemesh-Dive", made.dive.id);
    if (!made.job_id.empty()) response.set("Divemesh-Job", made.job_id);
    co_return response;
}

Awaitable<UploadTurns::Turn> take_turn(Request request, Services services) {
    // Whether it exists and may be seen comes first: others' requests are not to be stopped.
    auto look = [services, request] { visible_upload(request, services); };
    co_await in_pool(services.pool, std::move(look));
    auto stop = [stream = request.stream] { stream->stop(); };
    co_return co_await services.turns.take(request.parameter("upload_id"), std::move(stop));
}

Awaitable<Response> receive(Request request, Services services, Upload upload, Response response) {
    auto open = [services, upload] { return std::make_shared<UploadWriter>(services, upload); };
    auto writer = co_await in_pool(services.pool, std::move(open));
    const Appended appended = co_await append_body(request.stream, services, writer);
    throw_unless_whole(appended);
    response.set("Upload-Offset", std::to_string(appended.upload.offset_bytes));
    co_return co_await with_dive(std::move(response), appended.upload, services);
}

}  // namespace

Awaitable<Response> describe_uploads(Request, Services services) {
    Response response = empty_response(http::status::no_content);
    response.set("Tus-Version", "1.0.0");
    response.set("Tus-Extension", "creation,creation-with-upload,termination");
    response.set("Tus-Max-Size", std::to_string(services.limits.max_upload_bytes));
    co_return response;
}

Awaitable<Response> create_upload(Request request, Services services) {
    if (auto refused = wrong_version(request)) co_return std::move(*refused);
    const Upload wanted = announced_upload(request, services);
    const bool with_bytes = brings_bytes(request);
    if (with_bytes) check_content_length(request, wanted);
    if (!with_bytes && request.stream->length_bytes().value_or(1) > 0)
        throw Error(ErrorCode::Unsupported,
                    std::string("send the first bytes as Content-Type: ") + kBytesType);
    auto enter = [services, wanted] { return enter_upload(services, wanted); };
    const Upload upload = co_await in_pool(services.pool, std::move(enter));
    auto stop = [stream = request.stream] { stream->stop(); };
    auto turn = co_await services.turns.take(upload.id, std::move(stop));
    Response response = empty_response(http::status::created);
    response.set("Location", "/api/v1/uploads/" + upload.id);
    if (with_bytes) co_return co_await receive(request, services, upload, std::move(response));
    response.set("Upload-Offset", "0");
    co_return co_await with_dive(std::move(response), upload, services);
}

Awaitable<Response> get_upload_offset(Request request, Services services) {
    if (auto refused = wrong_version(request)) co_return std::move(*refused);
    auto turn = co_await take_turn(request, services);
    auto work = [services, request] {
        return reconciled(services, visible_upload(request, services));
    };
    const Upload upload = co_await in_pool(services.pool, std::move(work));
    Response response = empty_response(http::status::ok);
    response.set("Upload-Offset", std::to_string(upload.offset_bytes));
    response.set("Upload-Length", std::to_string(upload.length_bytes));
    if (!upload.metadata.empty()) response.set("Upload-Metadata", upload.metadata);
    if (!upload.dive_id.empty()) response.set("Divemesh-Dive", upload.dive_id);
    response.set("Cache-Control", "no-store");
    co_return response;
}

Awaitable<Response> get_upload(Request request, Services services) {
    auto work = [services, request] { return visible_upload(request, services); };
    const Upload upload = co_await in_pool(services.pool, std::move(work));
    co_return json_response(http::status::ok, upload);
}

Awaitable<Response> append_to_upload(Request request, Services services) {
    if (auto refused = wrong_version(request)) co_return std::move(*refused);
    if (!brings_bytes(request))
        throw Error(ErrorCode::Unsupported, std::string("send Content-Type: ") + kBytesType);
    const std::int64_t offset = count_header(request, "upload-offset");
    auto turn = co_await take_turn(request, services);
    auto fresh = [services, request] {
        return reconciled(services, visible_upload(request, services));
    };
    const Upload upload = co_await in_pool(services.pool, std::move(fresh));
    if (offset != upload.offset_bytes) {
        Response response = problem_response(
            request,
            http::status::conflict,
            "the next byte is number " + std::to_string(upload.offset_bytes) + ": ask by HEAD");
        response.set("Upload-Offset", std::to_string(upload.offset_bytes));
        co_return response;
    }
    check_content_length(request, upload);
    Response response = empty_response(http::status::no_content);
    if (!upload.complete())
        co_return co_await receive(request, services, upload, std::move(response));
    response.set("Upload-Offset", std::to_string(upload.offset_bytes));
    co_return co_await with_dive(std::move(response), upload, services);
}

Awaitable<Response> terminate_upload(Request request, Services services) {
    if (auto refused = wrong_version(request)) co_return std::move(*refused);
    auto turn = co_await take_turn(request, services);
    auto work = [services, request] {
        const Upload upload = visible_upload(request, services);
        storage::UploadStore(services.catalog).remove(upload.id);
        services.blobs.remove_staged(upload.blob);
        services.hashes.forget(upload.id);
        if (upload.dive_id.empty()) services.blobs.remove(archive_key(upload));
    };
    co_await in_pool(services.pool, std::move(work));
    co_return empty_response(http::status::no_content);
}

}  // namespace divemesh::api
