#include "api/browser_session.hpp"

#include <boost/beast/core/string.hpp>

#include "api/audit.hpp"
#include "api/cors.hpp"
#include "api/read_nonblocking.hpp"
#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "storage/browser_session_store.hpp"
#include "storage/token_store.hpp"

namespace divemesh::api {
namespace {

constexpr std::string_view kCookie = "divemesh_session";
// Over TLS: a browser takes it from this host alone, so no neighbour can put another in its place
// (RFC 6265bis, 4.1.3.2).
constexpr std::string_view kSecureCookie = "__Host-divemesh_session";

bool is_over_tls(const Request& request, const ServiceLimits& limits) {
    return limits.tls || request.is_https;
}

std::string_view cookie_name(const Request& request, const ServiceLimits& limits) {
    return is_over_tls(request, limits) ? kSecureCookie : kCookie;
}

std::string_view trimmed(std::string_view text) {
    const auto first = text.find_first_not_of(' ');
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

// The hashes differ from the first byte on whatever the texts share, so time tells nothing.
bool is_same_secret(const std::string& a, const std::string& b) {
    return sha256_hex(a) == sha256_hex(b);
}

void require_own_page(const Request& request,
                      const ServiceLimits& limits,
                      RouteKind kind,
                      const std::string& secret) {
    const bool is_socket = kind == RouteKind::WebSocket;
    const bool reads = request.method == verb::get || request.method == verb::head ||
                       request.method == verb::options;
    if (reads && !is_socket) return;
    if ((is_socket || request.has_header("origin")) && !is_own_origin(request, limits))
        throw Error(
            ErrorCode::Forbidden,
            "a session is only for pages of this server: the Origin must be its address, or "
            "send a token as Authorization: Bearer");
    if (!is_socket && !is_same_secret(request.header("x-csrf-token"), csrf_token(secret)))
        throw Error(ErrorCode::Forbidden,
                    "the X-CSRF-Token is missing or is that of another session: send the "
                    "csrf_token of GET /api/v1/session");
}

// Returns the token, for "" the oldest one with the scope admin, if it is valid.
std::optional<Token> token_to_sign_in_with(storage::TokenStore tokens, const std::string& id) {
    if (!id.empty()) return tokens.get_valid(id);
    for (const Token& token : tokens.list())
        if (token.allows("admin"))
            if (auto valid = tokens.get_valid(token.id)) return valid;
    return std::nullopt;
}

}  // namespace

std::optional<std::string> session_secret(const Request& request, const ServiceLimits& limits) {
    if (request.has_header("authorization")) return std::nullopt;
    const std::string cookies = request.header("cookie");
    const std::string_view name = cookie_name(request, limits);
    for (std::size_t start = 0; start < cookies.size();) {
        const std::size_t end = std::min(cookies.find(';', start), cookies.size());
        const auto pair = trimmed(std::string_view(cookies).substr(start, end - start));
        const auto equals = pair.find('=');
        if (equals != std::string_view::npos && pair.substr(0, equals) == name)
            return std::string(pair.substr(equals + 1));
        start = end + 1;
    }
    return std::nullopt;
}

std::string csrf_token(const std::string& secret) {
    return sha256_hex("csrf token of " + secret).substr(0, 32);
}

Awaitable<Token> find_session_token(Request request,
                                    Services services,
                                    RouteKind kind,
                                    std::string secret) {
    auto find = [secret](storage::Catalog& catalog) {
        return storage::BrowserSessionStore(catalog).find(secret);
    };
    const auto session = co_await read_nonblocking(services, std::move(find));
    if (!session)
        throw Error(ErrorCode::Unauthorized,
                    "this session has ended: sign in again, or send a token as Authorization: "
                    "Bearer");
    require_own_page(request, services.limits, kind, secret);
    co_return session->token;
}

std::string make_sign_in_path(const storage::Catalog& catalog,
                              const std::string& token_id,
                              const std::string& who) {
    auto noted = audited(catalog, who, "link to sign in");
    const auto owner = token_to_sign_in_with(storage::TokenStore(noted), token_id);
    if (!owner)
        throw Error(ErrorCode::NotFound,
                    token_id.empty() ? "no token with the scope admin is valid: create one first "
                                       "(divemesh token create --scope admin)"
                                     : "no valid token " + token_id + ": see divemesh token list");
    return "/sign-in#" + storage::TokenStore(noted)
                             .create_one_shot(*owner, std::string(kSessionPath), kSignInLifetime)
                             .secret;
}

void set_session_cookie(const Request& request,
                        const ServiceLimits& limits,
                        const std::string& secret,
                        Response& response) {
    const auto age =
        secret.empty() ? std::chrono::seconds(0) : std::chrono::seconds(storage::kSessionLifetime);
    const bool is_secure = is_over_tls(request, limits);
    response.set("Set-Cookie",
                 std::string(cookie_name(request, limits)) + "=" + secret +
                     "; Path=/; Max-Age=" + std::to_string(age.count()) +
                     "; HttpOnly; SameSite=Strict" + (is_secure ? "; Secure" : ""));
}

}  // namespace divemesh::api
