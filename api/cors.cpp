#include "api/cors.hpp"

#include <algorithm>

#include "api/public_url.hpp"

namespace divemesh::api {
namespace {

// Header fields that clients in browsers send and read.
constexpr const char* kSent =
    "Authorization, Content-Type, If-Match, If-None-Match, If-Range, Range, Idempotency-Key,"
    " Tus-Resumable, Upload-Length, Upload-Offset, Upload-Metadata, Upload-Defer-Length,"
    " Upload-Concat, Upload-Checksum, X-HTTP-Method-Override, X-Request-Id, traceparent";
constexpr const char* kRead =
    "Location, ETag, Link, Allow, Retry-After, RateLimit, Accept-Ranges, Content-Range,"
    " Content-Disposition, Content-Digest, Repr-Digest, Tus-Resumable, Tus-Version, Tus-Extension,"
    " Tus-Max-Size, Tus-Checksum-Algorithm, Upload-Offset, Upload-Length, Upload-Defer-Length,"
    " Upload-Metadata, Upload-Expires, Upload-Concat, Divemesh-Dive, Divemesh-Job,"
    " Idempotency-Replayed, X-Request-Id, traceparent";

bool is_listed(const Request& request, const ServiceLimits& limits) {
    const auto& allowed = limits.allowed_origins;
    return std::find(allowed.begin(), allowed.end(), request.header("origin")) != allowed.end();
}

}  // namespace

bool is_own_origin(const Request& request, const ServiceLimits& limits) {
    const std::string origin = request.header("origin");
    if (origin.empty()) return false;
    if (origin == public_origin(limits)) return true;
    const auto host = origin.find("://");
    return host != std::string::npos && origin.substr(host + 3) == request.header("host");
}

bool is_allowed_origin(const Request& request, const ServiceLimits& limits) {
    return !request.has_header("origin") || is_listed(request, limits) ||
           is_own_origin(request, limits);
}

std::optional<Response> answer_preflight(const Request& request,
                                         const std::vector<verb>& methods,
                                         const ServiceLimits& limits) {
    if (request.method != verb::options || !request.has_header("access-control-request-method") ||
        methods.empty() || !is_listed(request, limits))
        return std::nullopt;
    std::string names;
    for (const verb method : methods)
        names += (names.empty() ? "" : ", ") + std::string(http::to_string(method));
    Response response = empty_response(http::status::no_content);
    response.set("Access-Control-Allow-Methods", names);
    response.set("Access-Control-Allow-Headers", kSent);
    response.set("Access-Control-Max-Age", "600");
    return response;
}

void add_cors(const Request& request, const ServiceLimits& limits, Response& response) {
    if (limits.allowed_origins.empty()) return;
    response.add_vary("Origin");
    if (!is_listed(request, limits)) return;
    response.set("Access-Control-Allow-Origin", request.header("origin"));
    response.set("Access-Control-Expose-Headers", kRead);
}

}  // namespace divemesh::api
