#include "api/authorization.hpp"

#include <algorithm>
#include <boost/asio/ip/address_v4.hpp>
#include <boost/beast/core/string.hpp>

#include "api/browser_session.hpp"
#include "api/cors.hpp"
#include "api/in_pool.hpp"
#include "api/public_url.hpp"
#include "api/read_nonblocking.hpp"
#include "api/target.hpp"
#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "storage/token_store.hpp"

namespace divemesh::api {
namespace {

constexpr const char* kOneShot = "one_shot";
constexpr std::string_view kBearer = "Bearer ";

bool is_loopback_host(const std::string& host) {
    const auto port = host.rfind(':');
    const bool has_port = port != std::string::npos && !host.ends_with(']');
    const std::string name = has_port ? host.substr(0, port) : host;
    if (name == "localhost" || name == "[::1]") return true;
    boost::system::error_code failure;
    const auto address = boost::asio::ip::make_address_v4(name, failure);
    return !failure && address.is_loopback();
}

// Browsers send these themselves, and no page can leave them out (Fetch standard, forbidden request
// header names).
bool may_be_browser(const Request& request) {
    return request.has_header("accept-encoding") || request.has_header("origin");
}

// Without tokens a browser would do whatever any page that is open in it asks. A page whose own
// name leads to this machine (DNS rebinding) would even be of the same origin.
void refuse_other_pages(const Request& request, const ServiceLimits& limits) {
    const std::string host = request.header("host");
    if (may_be_browser(request) && !is_loopback_host(host) &&
        !public_origin(limits).ends_with("://" + host))
        throw Error(ErrorCode::Forbidden,
                    "without tokens this server answers only to its own name, not to " + host +
                        ": use 127.0.0.1 or localhost, or state the name with --public-url");
    const bool reads = request.method == verb::get || request.method == verb::head ||
                       request.method == verb::options;
    if (!reads && !is_allowed_origin(request, limits))
        throw Error(ErrorCode::Forbidden,
                    "pages of this origin are not allowed to change anything: start the server "
                    "with --allow-origin to allow it");
}

// What a sharing link opens, of its own job and that job's dive.
constexpr std::string_view kSharedPaths[] = {"/api/v1/jobs/{job_id}",
                                             "/api/v1/jobs/{job_id}/artifacts",
                                             "/api/v1/jobs/{job_id}/artifacts/{artifact_name...}",
                                             "/api/v1/jobs/{job_id}/artifacts.zip",
                                             "/api/v1/dives/{dive_id}",
                                             "/api/v1/dives/{dive_id}/thumbnail.jpg"};

Token administrator() {
    Token token;
    token.name = "no-auth";
    token.project = "default";
    token.scopes = {"admin"};
    return token;
}

std::string bearer_secret(const Request& request) {
    const std::string header = request.header("authorization");
    if (!boost::beast::iequals(header.substr(0, kBearer.size()), kBearer))
        throw Error(ErrorCode::Unauthorized,
                    "there is no token: send Authorization: Bearer dm_...");
    return header.substr(kBearer.size());
}

void refuse_token_in_address(const Request& request) {
    for (const char* name : {"token", "access_token"})
        if (request.query.contains(name))
            throw Error(
                ErrorCode::InvalidArgument,
                "a token must not be part of the address: send it as Authorization: Bearer");
}

// Returns the query that a one-shot token may be bound to.
std::string bound_query(const Request& request) {
    auto query = request.query;
    query.erase(kOneShot);
    return query_text(query);
}

Awaitable<Token> find_one_shot(std::string secret, Request request, Services services) {
    auto find = [secret = std::move(secret),
                 request = std::move(request)](storage::Catalog& catalog) {
        return storage::TokenStore(catalog).find_one_shot(
            secret, request.path, bound_query(request));
    };
    auto token = co_await read_nonblocking(services, std::move(find));
    if (!token) throw one_shot_used_up();
    co_return std::move(*token);
}

Awaitable<Token> find_token(std::string secret, Services services) {
    if (auto known = services.tokens.find(sha256_hex(secret))) co_return std::move(*known);
    auto find = [secret = std::move(secret)](storage::Catalog& catalog) {
        return storage::TokenStore(catalog).find(secret);
    };
    auto token = co_await read_nonblocking(services, std::move(find));
    if (!token)
        throw Error(ErrorCode::Unauthorized,
                    "this token is unknown, revoked or expired: use a valid one");
    services.tokens.put(*token);
    co_return std::move(*token);
}

}  // namespace

Awaitable<Token> authenticate(Request request, Services services, RouteKind kind) {
    refuse_token_in_address(request);
    if (services.no_auth) {
        refuse_other_pages(request, services.limits);
        co_return administrator();
    }
    if (request.query.contains(kOneShot)) {
        const bool is_taken = kind == RouteKind::File || kind == RouteKind::WebSocket;
        if (!is_taken || request.method != verb::get)
            throw Error(
                ErrorCode::InvalidArgument,
                "a one-shot token is only for GET of files and event streams: send another token");
        std::string one_shot = request.query.at(kOneShot);
        co_return co_await find_one_shot(std::move(one_shot), std::move(request), services);
    }
    if (auto cookie = session_secret(request, services.limits))
        co_return co_await find_session_token(
            std::move(request), services, kind, std::move(*cookie));
    auto one_shot = bearer_one_shot(request);
    if (one_shot && request.method == verb::post && request.path == kSessionPath)
        co_return co_await find_one_shot(std::move(*one_shot), std::move(request), services);
    co_return co_await find_token(bearer_secret(request), services);
}

std::optional<std::string> bearer_one_shot(const Request& request) {
    const std::string header = request.header("authorization");
    const std::string secret = header.substr(std::min(kBearer.size(), header.size()));
    return secret.starts_with(storage::kOneShotPrefix) ? std::optional(secret) : std::nullopt;
}

Error one_shot_used_up() {
    return {ErrorCode::Unauthorized,
            "this one-shot token was used, has expired or is for another path: create a new one"};
}

Awaitable<void> use_up_one_shot(Request request, Services services) {
    if (services.no_auth || !request.query.contains(kOneShot)) co_return;
    auto work = [&catalog = services.catalog, request = std::move(request)] {
        return storage::TokenStore(catalog)
            .redeem_one_shot(request.query.at(kOneShot), request.path, bound_query(request))
            .has_value();
    };
    const bool redeemed = co_await in_pool(services.pool, std::move(work));
    if (!redeemed) throw one_shot_used_up();
}

void require_scope(const Token& token, const std::string& scope) {
    if (scope != kAnyToken && !token.allows(scope))
        throw Error(ErrorCode::Forbidden, "this token does not have the scope " + scope);
}

void require_shared(const Token& token, const Request& request, const Route& route) {
    if (token.shared_job.empty() || route.path == kSessionPath) return;
    const auto names = [&request](std::string_view word, const std::string& id) {
        const auto found = request.parameters.find(word);
        return found == request.parameters.end() || found->second == id;
    };
    const bool is_open = route.method == verb::get &&
                         std::find(std::begin(kSharedPaths), std::end(kSharedPaths), route.path) !=
                             std::end(kSharedPaths) &&
                         names("job_id", token.shared_job) && names("dive_id", token.shared_dive);
    if (!is_open)
        throw Error(ErrorCode::Forbidden,
                    "a sharing link only opens the result of its job: use a token");
}

std::string visible_project(const Token& token) {
    return token.allows("admin") ? "" : token.project;
}

void require_visible(const Token& token, const std::string& project, const std::string& what) {
    const std::string visible = visible_project(token);
    if (!visible.empty() && visible != project) throw Error(ErrorCode::NotFound, "no " + what);
}

void require_sensor(const Token& token, const std::string& sensor) {
    if (!token.allows("admin") && token.sensor != sensor)
        throw Error(ErrorCode::NotFound, "no sensor " + sensor);
}

}  // namespace divemesh::api
