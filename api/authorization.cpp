#include "api/authorization.hpp"

#include <boost/beast/core/string.hpp>

#include "api/in_pool.hpp"
#include "schemas/error.hpp"
#include "storage/token_store.hpp"

namespace divemesh::api {
namespace {

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
        throw Error(ErrorCode::Unauthorized, "give a token: Authorization: Bearer dm_...");
    return header.substr(kScheme.size());
}

}  // namespace

Awaitable<Token> authenticate(Request request, Services services) {
    for (const char* name : {"token", "access_token"})
        if (request.query.contains(name))
            throw Error(
                ErrorCode::InvalidArgument,
                "a token does not belong into an address: send it as Authorization: Bearer");
    if (services.no_auth) co_return administrator();
    std::string secret = bearer_secret(request);
    auto find = [&catalog = services.catalog, secret = std::move(secret)] {
        return storage::TokenStore(catalog).find(secret);
    };
    auto token = co_await in_pool(services.pool, std::move(find));
    if (!token) throw Error(ErrorCode::Unauthorized, "this token is not known, or was revoked");
    co_return std::move(*token);
}

void require_scope(const Token& token, const std::string& scope) {
    if (!token.allows(scope))
        throw Error(ErrorCode::Forbidden, "this token lacks the scope " + scope);
}

std::string visible_project(const Token& token) {
    return token.allows("admin") ? "" : token.project;
}

void require_visible(const Token& token, const std::string& project, const std::string& what) {
    const std::string visible = visible_project(token);
    if (!visible.empty() && visible != project) throw Error(ErrorCode::NotFound, "no " + what);
}

}  // namespace divemesh::api
