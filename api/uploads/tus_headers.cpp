#include "api/uploads/tus_headers.hpp"

#include "api/error_response.hpp"
#include "api/field_values.hpp"
#include "api/target.hpp"
#include "schemas/error.hpp"

namespace divemesh::api {
namespace {

constexpr std::size_t kMaxMetadataBytes = 8192;
constexpr std::string_view kBytesType = "application/offset+octet-stream";
constexpr std::string_view kUploads = "/api/v1/uploads/";

[[noreturn]] void refuse(const std::string& why) { throw Error(ErrorCode::InvalidArgument, why); }

std::optional<std::int64_t> announced_length(const Request& request, std::int64_t max_bytes) {
    if (request.has_header("upload-defer-length")) {
        if (request.has_header("upload-length"))
            refuse("send either Upload-Length or Upload-Defer-Length, not both");
        if (request.header("upload-defer-length") != "1") refuse("Upload-Defer-Length must be 1");
        return std::nullopt;
    }
    const std::int64_t length = count_header(request, "upload-length");
    if (length > max_bytes)
        throw Error(ErrorCode::TooLarge,
                    "an upload may have at most " + std::to_string(max_bytes) + " bytes");
    return length;
}

std::string announced_concat(const Request& request) {
    std::string concat = request.header("upload-concat");
    if (request.has_header("upload-concat") && concat != "partial" && !concat.starts_with("final;"))
        refuse("Upload-Concat must be partial, or final; followed by the addresses of the parts");
    return concat;
}

std::string part_id(std::string_view url) {
    const auto start = url.rfind(kUploads);
    const auto id = start == std::string_view::npos
                        ? std::nullopt
                        : percent_decode(url.substr(start + kUploads.size()));
    if (!id || id->empty() || id->find_first_of("/?#") != std::string::npos)
        refuse("Upload-Concat contains an address that is not an upload of this server");
    return *id;
}

}  // namespace

std::optional<Response> wrong_version(const Request& request) {
    if (request.header("tus-resumable") == "1.0.0") return std::nullopt;
    Response response =
        problem_response(request,
                         http::status::precondition_failed,
                         "there is no Tus-Resumable: send Tus-Resumable: 1.0.0 with the request");
    response.set("Tus-Version", "1.0.0");
    return response;
}

std::int64_t count_header(const Request& request, const std::string& name) {
    const auto value = parse_count(request.header(name));
    if (!value) refuse(name + " must be a number of bytes");
    return *value;
}

bool brings_bytes(const Request& request) {
    if (media_type_of(request.header("content-type")) != kBytesType) return false;
    if (request.has_header("trailer"))
        throw Error(ErrorCode::Unsupported,
                    "trailers are not read: send Upload-Checksum as a header");
    return true;
}

void require_bytes(const Request& request) {
    if (!brings_bytes(request))
        throw Error(
            ErrorCode::Unsupported,
            "the body has another content type: send Content-Type: " + std::string(kBytesType));
}

Upload announced_upload(const Request& request, const ServiceLimits& limits) {
    Upload upload;
    upload.project = request.token.project;
    upload.token_id = request.token.id;
    upload.lifetime_ms = limits.upload_lifetime.count();
    upload.metadata = request.header("upload-metadata");
    if (upload.metadata.size() > kMaxMetadataBytes)
        refuse("Upload-Metadata is longer than 8192 bytes");
    upload.concat = announced_concat(request);
    if (!upload.is_final()) {
        upload.length_bytes = announced_length(request, limits.max_upload_bytes);
    } else if (request.has_header("upload-length") || request.has_header("upload-defer-length")) {
        refuse("a final upload has the length of its parts: send no Upload-Length");
    }
    return upload;
}

std::vector<std::string> parts_of(const Upload& final_upload) {
    std::vector<std::string> ids;
    std::string_view rest(final_upload.concat);
    rest.remove_prefix(rest.find(';') + 1);
    while (!rest.empty()) {
        const auto end = std::min(rest.find(' '), rest.size());
        if (end > 0) ids.push_back(part_id(rest.substr(0, end)));
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    if (ids.empty()) refuse("Upload-Concat names no part: give the addresses of the parts");
    return ids;
}

void set_progress(Response& response, const Upload& upload) {
    response.set("Upload-Offset", std::to_string(upload.offset_bytes));
    if (upload.expires_at_ms > 0)
        response.set("Upload-Expires", http_date(upload.expires_at_ms / 1000));
}

}  // namespace divemesh::api
