#include "api/authorization.hpp"

#include <algorithm>
#include <boost/beast/core/string.hpp>

#include "api/in_pool.hpp"
#include "api/read_nonblocking.hpp"
#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "storage/token_store.hpp"

namespace divemesh::api {
namespace {

constexpr const char* kOneShot = "one_shot";

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
    constexpr std::string_view kScheme = "Bearer ";
    const std::string header = request.header("authorization");
    if (!boost::beast::iequals(header.substr(0, kScheme.size()), kScheme))
        throw Error(ErrorCode::Unauthorized,
                    "there is no token: send Authorization: Bearer dm_...");
    return header.substr(kScheme.size());
}

void refuse_token_in_address(const Request& request) {
    for (const char* name : {"token", "access_token"})
        if (request.query.contains(name))
            throw Error(
                ErrorCode::InvalidArgument,
                "a token must not be part of the address: send it as Authorization: Bearer");
}

Error used_up() {
    return {ErrorCode::Unauthorized,
            "this one-shot token was used, has expired or is for another path: create a new one"};
}

Awaitable<Token> find_one_shot(Request request, Services services) {
    auto find = [request = std::move(request)](storage::Catalog& catalog) {
        return storage::TokenStore(catalog).find_one_shot(request.query.at(kOneShot), request.path);
    };
    auto token = co_await read_nonblocking(services, std::move(find));
    if (!token) throw used_up();
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

Awaitable<Token> authenticate(Request request, Services services, bool takes_one_shot) {
    refuse_token_in_address(request);
    if (services.no_auth) co_return administrator();
    if (!request.query.contains(kOneShot))
        co_return co_await find_token(bearer_secret(request), services);
    if (!takes_one_shot || request.method != verb::get)
        throw Error(
            ErrorCode::InvalidArgument,
            "a one-shot token is only for GET of files and event streams: send another token");
    co_return co_await find_one_shot(std::move(request), services);
}

Awaitable<void> use_up_one_shot(Request request, Services services) {
    if (services.no_auth || !request.query.contains(kOneShot)) co_return;
    auto work = [&catalog = services.catalog, request = std::move(request)] {
        return storage::TokenStore(catalog)
            .redeem_one_shot(request.query.at(kOneShot), request.path)
            .has_value();
    };
    const bool redeemed = co_await in_pool(services.pool, std::move(work));
    if (!redeemed) throw used_up();
}

void require_scope(const Token& token, const std::string& scope) {
    if (!token.allows(scope))
        throw Error(ErrorCode::Forbidden, "this token does not have the scope " + scope);
}

void require_shared(const Token& token, const Request& request, const Route& route) {
    if (token.shared_job.empty()) return;
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
