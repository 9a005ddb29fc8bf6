#include "api/handlers/sessions.hpp"

#include "api/audit.hpp"
#include "api/authorization.hpp"
#include "api/browser_session.hpp"
#include "api/handlers/json_body.hpp"
#include "api/in_pool.hpp"
#include "api/preconditions.hpp"
#include "api/read_nonblocking.hpp"
#include "schemas/error.hpp"
#include "storage/browser_session_store.hpp"

namespace divemesh::api {
namespace {

// Returns what the page has to know. `csrf_token` "": the request did not come by a session.
nlohmann::json session_json(const Token& token,
                            const std::string& csrf_token,
                            std::int64_t expires_at_ms) {
    return {{"token_id", token.id},
            {"name", token.name},
            {"project", token.project},
            {"scopes", token.scopes},
            {"shared_job", token.shared_job},
            {"shared_dive", token.shared_dive},
            {"expires_at_ms", expires_at_ms},
            {"csrf_token", csrf_token}};
}

storage::CreatedSession begin_session(const Services& services, const Request& request) {
    auto catalog = audited(services, request);
    storage::BrowserSessionStore sessions(catalog);
    const auto one_shot = bearer_one_shot(request);
    if (!one_shot) return sessions.create(request.token);
    auto created = sessions.redeem(*one_shot, request.path);
    if (!created) throw one_shot_used_up();
    return std::move(*created);
}

}  // namespace

Awaitable<Response> create_session(Request request, Services services) {
    if (services.no_auth) co_return secret_response(session_json(request.token, "", 0));
    if (session_secret(request, services.limits))
        throw Error(ErrorCode::Unauthorized,
                    "a session begins with a token: send it as Authorization: Bearer");
    auto begin = [services, request] { return begin_session(services, request); };
    const auto created = co_await in_pool(services.pool, std::move(begin));
    Response response = secret_response(session_json(
        created.session.token, csrf_token(created.secret), created.session.expires_at_ms));
    set_session_cookie(request, services.limits, created.secret, response);
    co_return response;
}

Awaitable<Response> get_session(Request request, Services services) {
    const auto secret = services.no_auth ? std::nullopt : session_secret(request, services.limits);
    nlohmann::json shown = session_json(request.token, "", request.token.expires_at_ms);
    if (secret) {
        auto find = [secret](storage::Catalog& catalog) {
            return storage::BrowserSessionStore(catalog).find(*secret);
        };
        const auto session = co_await read_nonblocking(services, std::move(find));
        if (session)
            shown = session_json(session->token, csrf_token(*secret), session->expires_at_ms);
    }
    Response response = json_response(http::status::ok, shown);
    response.set("Cache-Control", "no-store");
    co_return response;
}

Awaitable<Response> end_session(Request request, Services services) {
    require_no_tag(request);
    const auto secret = services.no_auth ? std::nullopt : session_secret(request, services.limits);
    if (secret) {
        auto end = [services, request, secret] {
            auto catalog = audited(services, request);
            storage::BrowserSessionStore(catalog).end(*secret);
        };
        co_await in_pool(services.pool, std::move(end));
    }
    Response response = empty_response(http::status::no_content);
    set_session_cookie(request, services.limits, "", response);
    response.set("Clear-Site-Data", "\"cache\"");  // models and images that the browser has kept
    co_return response;
}

}  // namespace divemesh::api
