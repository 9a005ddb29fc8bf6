#include "api/handlers/tokens.hpp"

#include <algorithm>

#include "api/handlers/json_body.hpp"
#include "api/in_pool.hpp"
#include "schemas/json.hpp"
#include "storage/token_store.hpp"

namespace divemesh::api {
namespace {

constexpr std::size_t kMaxNameBytes = 100;
constexpr std::size_t kMaxProjectBytes = 63;

bool is_project(const std::string& text) {
    const auto letter_or_digit = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
    };
    return !text.empty() && text.size() <= kMaxProjectBytes && letter_or_digit(text.front()) &&
           std::all_of(text.begin(), text.end(), [&](char c) {
               return letter_or_digit(c) || c == '-' || c == '_';
           });
}

struct TokenRequest {
    std::string name;
    std::string project;
    std::vector<std::string> scopes;
};

TokenRequest token_request(const Request& request) {
    const auto body = json_body(request, {"name", "project", "scopes"});
    TokenRequest wanted{value_or<std::string>(body, "name", ""),
                        value_or<std::string>(body, "project", "default"),
                        value_or<std::vector<std::string>>(body, "scopes", {})};
    if (wanted.name.empty() || wanted.name.size() > kMaxNameBytes)
        throw Error(ErrorCode::InvalidArgument, "\"name\" has to be 1 to 100 bytes long");
    if (!is_project(wanted.project))
        throw Error(ErrorCode::InvalidArgument,
                    "\"project\" has to be a-z 0-9 _ -, beginning with a letter or digit");
    return wanted;
}

}  // namespace

Awaitable<Response> list_tokens(Request request, Services services) {
    auto work = [&catalog = services.catalog] { return storage::TokenStore(catalog).list(); };
    const auto tokens = co_await in_pool(services.pool, std::move(work));
    co_return list_response(request, tokens);
}

Awaitable<Response> create_token(Request request, Services services) {
    auto work = [&catalog = services.catalog, wanted = token_request(request)] {
        return storage::TokenStore(catalog).create(wanted.name, wanted.project, wanted.scopes);
    };
    const auto created = co_await in_pool(services.pool, std::move(work));
    nlohmann::json body = created.token;
    body["secret"] = created.secret;
    Response response = json_response(http::status::created, body);
    response.set("Cache-Control", "no-store");
    co_return response;
}

Awaitable<Response> revoke_token(Request request, Services services) {
    auto work = [&catalog = services.catalog, id = request.parameter("token_id")] {
        storage::TokenStore(catalog).revoke(id);
    };
    co_await in_pool(services.pool, std::move(work));
    co_return empty_response(http::status::no_content);
}

}  // namespace divemesh::api
