#include "api/idempotency.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "api/error_response.hpp"
#include "api/in_pool.hpp"
#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "schemas/log.hpp"
#include "storage/idempotency_store.hpp"

namespace divemesh::api {
namespace {

constexpr std::size_t kMaxKeyBytes = 255;

// Returns the key. The draft's form is a quoted string; clients send bare keys as often.
std::string key_of(const Request& request) {
    std::string key = request.header("idempotency-key");
    if (key.size() >= 2 && key.starts_with('"') && key.ends_with('"'))
        key = key.substr(1, key.size() - 2);
    const bool plain = std::all_of(key.begin(), key.end(), [](char c) {
        return c >= 0x20 && c <= 0x7e && c != '"' && c != '\\';
    });
    if (key.empty() || key.size() > kMaxKeyBytes || !plain)
        throw Error(ErrorCode::InvalidArgument,
                    "Idempotency-Key must be 1 to 255 printable ASCII characters");
    return key;
}

std::string fingerprint_of(const Request& request) {
    Sha256 hash;
    const auto add = [&](const std::string& text) {
        hash.update(std::to_string(text.size()) + ":");
        hash.update(text);
    };
    add(std::string(http::to_string(request.method)));
    add(request.path);
    for (const auto& [name, value] : request.query) add(name), add(value);
    add(request.body);
    return hash.hex();
}

Response replayed(const storage::StoredAnswer& answer) {
    Response response = empty_response(static_cast<http::status>(answer.status));
    for (const auto& header : nlohmann::json::parse(answer.headers))
        response.set(header.at(0), header.at(1));
    response.body = answer.body;
    response.set("Idempotency-Replayed", "true");
    return response;
}

storage::StoredAnswer stored(const Response& response, const std::string& fingerprint) {
    return {fingerprint,
            static_cast<int>(response.status),
            nlohmann::json(response.headers).dump(),
            std::get<std::string>(response.body)};
}

// Stores the response. If it cannot be stored, the work still stays done.
void keep(storage::Catalog& catalog,
          const Request& request,
          const std::string& key,
          const storage::StoredAnswer& answer) {
    try {
        storage::IdempotencyStore(catalog).put(request.token.id, key, answer);
    } catch (const std::exception& error) {
        log_warning(
            {{"event", "answer_not_kept"}, {"request_id", request.id}, {"what", error.what()}});
    }
}

}  // namespace

std::shared_ptr<const std::string> KeysInFlight::enter(const std::string& key) {
    const std::lock_guard lock(mutex_);
    if (!keys_.insert(key).second) return nullptr;
    return {new std::string(key), [this](const std::string* held) {
                const std::lock_guard again(mutex_);
                keys_.erase(*held);
                delete held;
            }};
}

std::string request_key(const Request& request) {
    if (!request.has_header("idempotency-key")) return "";
    return sha256_hex(request.token.id + "\n" + key_of(request) + "\n" + fingerprint_of(request));
}

Awaitable<Response> answer_once(Request request, Services services, const Route& route) {
    if (!request.has_header("idempotency-key"))
        co_return co_await route.handler(std::move(request), services);
    if (route.kind == RouteKind::Secret)
        throw Error(ErrorCode::InvalidArgument,
                    "the answer contains a secret, which is not stored: send no Idempotency-Key, "
                    "and if the answer is lost, list what exists");
    const std::string key = key_of(request);
    const std::string fingerprint = fingerprint_of(request);
    const auto turn = services.keys.enter(request.token.id + "\n" + key);
    if (!turn) {
        Response wait =
            problem_response(request,
                             http::status::conflict,
                             "a request with this Idempotency-Key is in progress: try again later");
        wait.set("Retry-After", "2");
        co_return wait;
    }
    auto find = [&catalog = services.catalog, request, key] {
        return storage::IdempotencyStore(catalog).find(request.token.id, key);
    };
    const auto known = co_await in_pool(services.pool, std::move(find));
    if (known && known->fingerprint != fingerprint)
        throw Error(ErrorCode::BadData,
                    "this Idempotency-Key was used for another request: use a new one");
    if (known) co_return replayed(*known);
    const Response response = co_await route.handler(request, services);
    if (http::to_status_class(response.status) == http::status_class::successful) {
        auto put =
            [&catalog = services.catalog, request, key, answer = stored(response, fingerprint)] {
                keep(catalog, request, key, answer);
            };
        co_await in_pool(services.pool, std::move(put));
    }
    co_return response;
}

}  // namespace divemesh::api
