#include "api/handlers/tokens.hpp"

#include "api/audit.hpp"
#include "api/browser_session.hpp"
#include "api/handlers/json_body.hpp"
#include "api/handlers/resource.hpp"
#include "api/in_pool.hpp"
#include "api/public_url.hpp"
#include "api/query_parameters.hpp"
#include "api/router.hpp"
#include "api/target.hpp"
#include "schemas/invalid_input.hpp"
#include "schemas/json.hpp"
#include "storage/token_store.hpp"

namespace divemesh::api {
namespace {

storage::NewToken token_request(const Request& request) {
    const auto body = json_body(request, {"name", "project", "scopes", "sensor", "expires_in_s"});
    return {.name = value_or<std::string>(body, "name", ""),
            .project = value_or<std::string>(body, "project", "default"),
            .scopes = value_or<std::vector<std::string>>(body, "scopes", {}),
            .sensor = value_or<std::string>(body, "sensor", ""),
            .lifetime = std::chrono::seconds(value_or<std::int64_t>(body, "expires_in_s", 0))};
}

// Returns the path of a one-shot token, with the query that it is bound to: paths that a browser
// opens by itself, without custom headers, i.e. downloads and event streams, and the one that signs
// a browser in.
std::string one_shot_path(const Request& request) {
    const auto body = json_body(request, {"path"});
    const auto text = value_or<std::string>(body, "path", "");
    if (text == kSessionPath) return text;
    Request opened;
    if (text.starts_with('/')) {
        Target target = parse_target(text);
        opened.path = std::move(target.path);
        opened.query = std::move(target.query);
    }
    const Route* route = opened.path.empty() ? nullptr : find_route(verb::get, opened.path).route;
    if (route == nullptr || (route->kind != RouteKind::File && route->kind != RouteKind::WebSocket))
        throw InvalidInput(
            {{"\"path\" must be that of a file or an event stream, or /api/v1/session",
              "/path",
              ""}});
    if (opened.query.contains("one_shot"))
        throw InvalidInput({{"\"path\" has a one_shot already: leave it out", "/path", ""}});
    require_known_query(opened, *route);
    return opened.query.empty() ? opened.path : opened.path + "?" + query_text(opened.query);
}

std::string opening_address(const std::string& path, const std::string& secret) {
    if (path == kSessionPath) return "/sign-in#" + secret;  // which no log sees
    const char* separator = path.find('?') == std::string::npos ? "?" : "&";
    return path + separator + "one_shot=" + secret;
}

}  // namespace

Awaitable<Response> list_tokens(Request request, Services services) {
    auto read = [](const Request&, storage::Catalog& catalog) {
        return storage::TokenStore(catalog).list();
    };
    return get_list(std::move(request), services, read);
}

Awaitable<Response> create_token(Request request, Services services) {
    auto work = [services, request, wanted = token_request(request)] {
        auto catalog = audited(services, request);
        return storage::TokenStore(catalog).create(wanted);
    };
    const auto created = co_await in_pool(services.pool, std::move(work));
    nlohmann::json body = created.token;
    body["secret"] = created.secret;
    co_return secret_response(body);
}

Awaitable<Response> revoke_token(Request request, Services services) {
    auto revoke = [services](const Request& asked, storage::Catalog& catalog) {
        storage::TokenStore(catalog).revoke(asked.parameter("token_id"));
        services.tokens.clear();
    };
    return delete_untagged_resource(std::move(request), services, revoke);
}

Awaitable<Response> create_one_shot_token(Request request, Services services) {
    auto work = [services, request, path = one_shot_path(request)] {
        auto catalog = audited(services, request);
        const std::chrono::seconds lifetime =
            path == kSessionPath ? kSignInLifetime : storage::kOneShotLifetime;
        return storage::TokenStore(catalog).create_one_shot(request.token, path, lifetime);
    };
    const auto made = co_await in_pool(services.pool, std::move(work));
    const std::string address = opening_address(made.path, made.secret);
    co_return secret_response({{"secret", made.secret},
                               {"path", made.path},
                               {"url", public_address(services.limits, address)},
                               {"expires_at_ms", made.expires_at_ms}});
}

}  // namespace divemesh::api
