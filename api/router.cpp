#include "api/router.hpp"

#include <algorithm>
#include <optional>

#include "api/audit.hpp"
#include "api/authorization.hpp"
#include "api/content_coding.hpp"
#include "api/cors.hpp"
#include "api/disk_reserve.hpp"
#include "api/error_response.hpp"
#include "api/etag.hpp"
#include "api/field_values.hpp"
#include "api/idempotency.hpp"
#include "api/in_pool.hpp"
#include "api/public_url.hpp"
#include "api/query_parameters.hpp"
#include "api/target.hpp"
#include "schemas/error.hpp"

namespace divemesh::api {
namespace {

constexpr std::chrono::seconds kPlainBodyTime{30};
constexpr std::string_view kUploadsPath = "/api/v1/uploads";

using Parameters = std::map<std::string, std::string, std::less<>>;

std::string_view next_segment(std::string_view& path) {
    path.remove_prefix(1);  // the slash
    const auto segment = path.substr(0, path.find('/'));
    path.remove_prefix(segment.size());
    return segment;
}

bool bind(Parameters& parameters, std::string_view name, std::string_view escaped, bool slashes) {
    auto value = percent_decode(escaped);
    if (!value || value->empty()) return false;
    if (!slashes && value->find('/') != std::string::npos) return false;
    parameters.emplace(name, std::move(*value));
    return true;
}

// Returns the parameters if `path` matches `pattern`; otherwise nullopt.
std::optional<Parameters> match(std::string_view pattern, std::string_view path) {
    Parameters parameters;
    while (pattern.starts_with('/') && path.starts_with('/')) {
        const std::string_view rest = path.substr(1);
        const auto expected = next_segment(pattern);
        const auto actual = next_segment(path);
        if (expected.ends_with("...}")) {
            if (!bind(parameters, expected.substr(1, expected.size() - 5), rest, true))
                return std::nullopt;
            return parameters;
        }
        if (expected.starts_with('{')) {
            if (!bind(parameters, expected.substr(1, expected.size() - 2), actual, false))
                return std::nullopt;
        } else if (expected != actual) {
            return std::nullopt;
        }
    }
    if (!pattern.empty() || !path.empty()) return std::nullopt;
    return parameters;
}

// Returns the method, also for clients behind a proxy that passes only GET and POST (tus 1.0).
verb effective_method(const Request& request) {
    if (request.method != verb::post || !request.path.starts_with(kUploadsPath))
        return request.method;
    const std::string wanted = request.header("x-http-method-override");
    if (wanted == "PATCH") return verb::patch;
    if (wanted == "DELETE") return verb::delete_;
    if (wanted == "HEAD") return verb::head;
    return request.method;
}

Awaitable<std::string> read_body(std::shared_ptr<BodyStream> stream) {
    const Error too_large(ErrorCode::TooLarge,
                          "the body is larger than " + std::to_string(kMaxBodyBytes) + " bytes");
    if (stream->length_bytes().value_or(0) > static_cast<std::int64_t>(kMaxBodyBytes))
        throw too_large;
    stream->must_end_within(kPlainBodyTime);
    std::string body;
    std::vector<char> buffer(std::size_t{64} << 10);
    for (;;) {
        const BodyRead read = co_await stream->read(buffer);
        body.append(buffer.data(), read.num_bytes);
        if (body.size() > kMaxBodyBytes) throw too_large;
        if (read.state == BodyRead::State::End) co_return body;
        if (read.state == BodyRead::State::Invalid)
            throw Error(ErrorCode::InvalidArgument,
                        "the chunks of the body are invalid: send the request again");
        if (read.state != BodyRead::State::More)
            throw Error(ErrorCode::Unavailable,
                        "the body did not arrive completely: send the request again");
    }
}

Response no_route(const Request& request, const RouteMatch& match) {
    if (match.methods.empty())
        return problem_response(
            request, http::status::not_found, "there is no such address: see the API description");
    std::string allowed;
    for (const verb method : match.methods)
        allowed += (allowed.empty() ? "" : ", ") + std::string(http::to_string(method));
    Response response =
        problem_response(request,
                         http::status::method_not_allowed,
                         "the method is not allowed: this address takes " + allowed);
    response.set("Allow", allowed);
    return response;
}

// Returns the caller's token. Refuses an address with too many failed logins.
Awaitable<Token> identify(Request request, Services services, RouteKind kind) {
    const std::string peer = request.peer;
    try {
        co_return co_await authenticate(std::move(request), services, kind);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::Unauthorized || services.failed_logins.allow(peer)) throw;
    }
    throw TooOften("too many requests without a valid token: wait a while",
                   services.failed_logins.advice("address"));
}

void split_target(Request& request) {
    Target target = parse_target(request.target);
    request.path = std::move(target.path);
    request.query = std::move(target.query);
    if (!target.host.empty()) request.headers["host"] = std::move(target.host);  // RFC 9112, 3.2.2
    request.method = effective_method(request);
}

// Returns the response to a body in a coding that the server does not decode; nullopt for others.
std::optional<Response> refuse_coding(const Request& request) {
    const auto codings = list_elements(request.header("content-encoding"));
    const auto is_identity = [](const std::string& coding) { return coding == "identity"; };
    if (std::all_of(codings.begin(), codings.end(), is_identity) ||
        request.stream->length_bytes() == 0)
        return std::nullopt;
    const Error unsupported(ErrorCode::Unsupported,
                            "the Content-Encoding is not supported: send the body without it");
    Response response = error_response(request, std::make_exception_ptr(unsupported));
    response.set("Accept-Encoding", "identity");
    return response;
}

// Answers a form, which people new to this send, with the command that does what they want.
void refuse_form(const Request& request, const ServiceLimits& limits) {
    if (media_type_of(request.header("content-type")) != "multipart/form-data") return;
    const std::string scheme = request.is_https ? "https://" : "http://";
    const std::string server =
        limits.public_url.empty() ? scheme + request.header("host") : limits.public_url;
    throw Error(
        ErrorCode::Unsupported,
        "forms are not read: send an archive of a dive with divemesh upload dive.zip "
        "--server " +
            server +
            ", or with curl -H \"Authorization: Bearer $TOKEN\" -H \"Tus-Resumable: 1.0.0\" "
            "-H \"Upload-Length: $(stat -c %s dive.zip)\" -H \"Upload-Metadata: commit\" "
            "-H \"Content-Type: application/offset+octet-stream\" --data-binary @dive.zip " +
            server + std::string(kUploadsPath));
}

// Returns the response that needs no handler: to preflights, and to addresses and origins that are
// refused.
std::optional<Response> answer_at_the_door(const Request& request,
                                           const RouteMatch& match,
                                           const ServiceLimits& limits) {
    if (auto preflight = answer_preflight(request, match.methods, limits)) return preflight;
    if (match.route == nullptr) return no_route(request, match);
    if (match.route->kind == RouteKind::WebSocket && !is_allowed_origin(request, limits))
        throw Error(ErrorCode::Forbidden,
                    "pages of this origin are not allowed to connect: start the server with "
                    "--allow-origin to allow it");
    refuse_form(request, limits);
    return refuse_coding(request);
}

Awaitable<Token> admit(Request request, Services services, const Route* route) {
    Token token = co_await identify(request, services, route->kind);
    if (!services.rates.allow(token.id))
        throw TooOften("too many requests with this token: wait a while",
                       services.rates.advice("token"));
    require_shared(token, request, *route);
    require_scope(token, std::string(route->scope));
    co_return token;
}

void add_common_headers(const Request& request, const Services& services, Response& response) {
    if (request.path.starts_with(kUploadsPath)) response.set("Tus-Resumable", "1.0.0");
    response.set("X-Request-Id", request.id);
    if (!request.trace_id.empty()) response.set("traceparent", request.header("traceparent"));
    response.set("X-Content-Type-Options", "nosniff");
    // What the API answers is data: shown by itself it loads nothing, runs nothing, is in no frame.
    if (!response.has("Content-Security-Policy"))
        response.set("Content-Security-Policy",
                     "default-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors "
                     "'none'");
    if (!response.has("Referrer-Policy")) response.set("Referrer-Policy", "no-referrer");
    if (services.limits.hsts.count() > 0)
        response.set("Strict-Transport-Security",
                     "max-age=" + std::to_string(services.limits.hsts.count()));
    publish_addresses(services.limits, response);
    add_cors(request, services.limits, response);
    add_etag(request, response);
}

}  // namespace

RouteMatch find_route(verb method, std::string_view path) {
    RouteMatch result;
    const Route* get = nullptr;
    for (const Route& route : routes()) {
        auto parameters = match(route.path, path);
        if (!parameters) continue;
        result.methods.push_back(route.method);
        if (route.method == verb::get) get = &route;
        if (route.method == method) result.route = &route;
        result.parameters = std::move(*parameters);
    }
    if (result.route == nullptr && method == verb::head) result.route = get;
    return result;
}

namespace {

// Returns whether the body is read before the handler runs.
bool is_whole(RouteKind kind) { return kind == RouteKind::Plain || kind == RouteKind::Secret; }

// A deletion needs some space for its entry in the catalog: on a full disk it uses the reserve.
Awaitable<Response> answer(Request request, Services services, const Route& route) {
    if (route.method == verb::post && is_whole(route.kind))
        co_return co_await answer_once(request, services, route);
    if (route.method != verb::delete_) co_return co_await route.handler(request, services);
    std::exception_ptr failure;
    try {
        co_return co_await route.handler(request, services);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::OutOfSpace) throw;
        failure = std::current_exception();
    }
    auto release = [services] { return services.reserve.release(); };
    const bool released = co_await in_pool(services.pool, std::move(release));
    if (!released) std::rethrow_exception(failure);
    co_return co_await route.handler(request, services);
}

}  // namespace

Awaitable<Response> dispatch(Request request, Services services) {
    std::exception_ptr failure;
    const Route* route = nullptr;
    Response response;
    try {
        split_target(request);
        RouteMatch match = find_route(request.method, request.path);
        route = match.route;
        auto answered = answer_at_the_door(request, match, services.limits);
        if (answered) {
            response = std::move(*answered);
        } else {
            request.parameters = std::move(match.parameters);
            if (!route->scope.empty()) {
                request.token = co_await admit(request, services, route);
                request.stream->note_valid_token();
            }
            require_known_query(request, *route);
            if (is_whole(route->kind)) request.body = co_await read_body(request.stream);
            response = co_await answer(request, services, *route);
            if (http::to_status_class(response.status) < http::status_class::client_error) {
                if (!route->scope.empty()) co_await use_up_one_shot(request, services);
                co_await audit_visit(request, services);
            }
        }
    } catch (...) {
        failure = std::current_exception();
    }
    if (failure) response = error_response(request, failure);
    response.route = route;
    response.token_id = request.token.id;
    if (response.uploaded_bytes && !response.audited) {
        auto audit = [services, request, num_bytes = *response.uploaded_bytes] {
            audit_uploaded(services, request, num_bytes);
        };
        co_await in_pool(services.pool, std::move(audit));
    }
    add_common_headers(request, services, response);
    co_return co_await with_content_coding(request, services, std::move(response));
}

}  // namespace divemesh::api
