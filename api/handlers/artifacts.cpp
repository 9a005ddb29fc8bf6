#include "api/handlers/artifacts.hpp"

#include <algorithm>
#include <sstream>

#include "api/byte_range.hpp"
#include "api/error_response.hpp"
#include "api/etag.hpp"
#include "api/handlers/json_body.hpp"
#include "api/in_pool.hpp"
#include "api/uploads/upload_metadata.hpp"
#include "api/visible.hpp"
#include "api/zip_source.hpp"
#include "schemas/artifact.hpp"
#include "storage/dive_store.hpp"
#include "storage/job_store.hpp"
#include "storage/truth_store.hpp"

namespace divemesh::api {
namespace {

constexpr std::string_view kAskEachTime = "private, no-cache";
constexpr std::string_view kForEver = "private, max-age=31536000, immutable";  // RFC 8246

// A report has its style and its images in itself, and nothing that runs: that it may show.
constexpr std::string_view kReportPolicy =
    "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src data:";

struct StoredFile {
    std::string name;
    std::string media_type;
    std::string etag;
    std::string sha256;  // "": unknown
    std::string_view freshness = kAskEachTime;
    bool is_report = false;  // a page of ours that people read in the browser
    std::shared_ptr<storage::BlobReader> reader;
};

// Returns whether a browser would run it or render it as a page: such a file is sent as a download,
// in a sandbox. A report is shown.
bool is_active(const std::string& media_type) {
    return media_type.starts_with("text/html") || media_type.find("svg") != std::string::npos ||
           media_type.find("xml") != std::string::npos;
}

void describe(Response& response, const StoredFile& file) {
    response.set("ETag", file.etag);
    response.set("Accept-Ranges", "bytes");
    response.set("Cache-Control", std::string(file.freshness));
    if (!file.sha256.empty()) response.set("Repr-Digest", digest_field(file.sha256));
    response.set("Content-Type", file.media_type);
    const bool active = is_active(file.media_type);
    const bool shown = !active || file.is_report;
    response.set("Content-Disposition",
                 content_disposition(shown ? "inline" : "attachment", file.name));
    if (active)
        response.set("Content-Security-Policy",
                     file.is_report ? std::string(kReportPolicy) : "sandbox; default-src 'none'");
}

// Returns Cache-Control. With ?sha256= an address always means the same bytes; without it the bytes
// behind the name may change.
std::string_view freshness_of(const Request& request, const Artifact& artifact) {
    if (!request.query.contains("sha256")) return kAskEachTime;
    const std::string wanted = query_value(request, "sha256");
    check_sha256(wanted, "sha256");
    if (wanted != artifact.sha256)
        throw Error(
            ErrorCode::NotFound,
            "the sha256 of " + artifact.name + " is " + artifact.sha256 + ", not " + wanted);
    return kForEver;
}

// Returns the Range to serve of a file with a strong ETag. There is no Last-Modified that a client
// could send back.
std::string range_of(const Request& request, const StoredFile& file) {
    const std::string if_range = request.header("if-range");
    const bool is_same = if_range.empty() || if_range == file.etag;
    return request.method == verb::get && is_same ? request.header("range") : "";
}

Response file_response(const Request& request, const StoredFile& file) {
    if (request.has_header("if-match")) require_listed(request.header("if-match"), file.etag);
    if (matches_etag(request.header("if-none-match"), file.etag)) {
        Response response = empty_response(http::status::not_modified);
        response.set("ETag", file.etag);
        response.set("Cache-Control", std::string(file.freshness));
        return response;
    }
    const std::int64_t size = file.reader->size_bytes();
    const auto answer = parse_range(range_of(request, file), size);
    if (!answer.range) {
        Response response = problem_response(request,
                                             http::status::range_not_satisfiable,
                                             "the file has " + std::to_string(size) + " bytes");
        response.set("Content-Range", "bytes */" + std::to_string(size));
        return response;
    }
    const auto [offset, length] = *answer.range;
    Response response =
        empty_response(answer.partial ? http::status::partial_content : http::status::ok);
    describe(response, file);
    if (!answer.partial && !file.sha256.empty())
        response.set("Content-Digest", digest_field(file.sha256));
    if (answer.partial)
        response.set("Content-Range",
                     "bytes " + std::to_string(offset) + "-" + std::to_string(offset + length - 1) +
                         "/" + std::to_string(size));
    response.body = FilePart{file.reader, offset, length};
    return response;
}

}  // namespace

Awaitable<Response> get_artifact(Request request, Services services) {
    auto work = [services, request] {
        const Job job = visible_job(request, services.catalog);
        const Artifact artifact = storage::JobStore(services.catalog)
                                      .artifact(job.id, request.parameter("artifact_name"));
        const auto freshness = freshness_of(request, artifact);
        return StoredFile{artifact.name,
                          artifact.media_type,
                          '"' + artifact.sha256 + '"',
                          artifact.sha256,
                          freshness,
                          artifact.name == "report.html",
                          services.blobs.open(artifact.blob)};
    };
    const StoredFile file = co_await in_pool(services.pool, std::move(work));
    co_return file_response(request, file);
}

namespace {

// Returns the artifacts that ?names= lists, all without it. Throws Error{NotFound} for another
// name.
std::vector<Artifact> chosen_artifacts(const Request& request, std::vector<Artifact> all) {
    if (!request.query.contains("names")) return all;
    std::vector<Artifact> chosen;
    std::istringstream names(query_value(request, "names"));
    for (std::string name; std::getline(names, name, ',');) {
        const auto is_it = [&name](const Artifact& artifact) { return artifact.name == name; };
        const auto found = std::find_if(all.begin(), all.end(), is_it);
        if (found == all.end()) throw Error(ErrorCode::NotFound, "the job has no artifact " + name);
        if (std::none_of(chosen.begin(), chosen.end(), is_it)) chosen.push_back(*found);
    }
    return chosen;
}

}  // namespace

Awaitable<Response> get_artifacts_archive(Request request, Services services) {
    auto work = [services, request]() -> std::shared_ptr<BodySource> {
        const Job job = visible_job(request, services.catalog);
        std::vector<ZippedFile> files;
        for (const Artifact& artifact :
             chosen_artifacts(request, storage::JobStore(services.catalog).artifacts(job.id)))
            files.push_back({artifact.name, artifact.blob, artifact.size_bytes});
        if (files.empty())
            throw Error(ErrorCode::NotFound, "job " + job.id + " has no artifacts to pack");
        return zip_source(services.blobs, std::move(files), job.finished_at_ms / 1000);
    };
    auto source = co_await in_pool(services.pool, std::move(work));
    Response response = empty_response(http::status::ok);
    response.set("Content-Type", "application/zip");
    response.set("Cache-Control", std::string(kAskEachTime));
    response.set("Content-Disposition",
                 content_disposition("attachment", request.parameter("job_id") + ".zip"));
    response.body = StreamedBody{std::move(source)};
    co_return response;
}

// A dive has one thumbnail and keeps it: its key in the blob store is the tag.
Awaitable<Response> get_thumbnail(Request request, Services services) {
    auto work = [services, request] {
        const Dive dive = visible_dive(request, services.catalog);
        const std::string blob = storage::DiveStore(services.catalog).thumbnail_blob(dive.id);
        return StoredFile{"thumbnail.jpg",
                          "image/jpeg",
                          '"' + sha256_hex(blob).substr(0, 32) + '"',
                          "",
                          kAskEachTime,
                          false,
                          services.blobs.open(blob)};
    };
    const StoredFile file = co_await in_pool(services.pool, std::move(work));
    co_return file_response(request, file);
}

// Sends it as bytes, not as a page: its content is whatever a user has uploaded.
Awaitable<Response> get_truth_content(Request request, Services services) {
    auto work = [services, request] {
        const Dive dive = visible_dive(request, services.catalog);
        const TruthFile file =
            storage::TruthStore(services.catalog).get(dive.id, request.parameter("truth_id"));
        return StoredFile{file.name,
                          "application/octet-stream",
                          '"' + file.sha256 + '"',
                          file.sha256,
                          kAskEachTime,
                          false,
                          services.blobs.open(file.blob)};
    };
    const StoredFile file = co_await in_pool(services.pool, std::move(work));
    co_return file_response(request, file);
}

}  // namespace divemesh::api
