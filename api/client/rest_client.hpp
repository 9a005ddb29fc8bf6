#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "api/client/backoff.hpp"
#include "api/client/http_connection.hpp"
#include "schemas/error.hpp"

namespace divemesh::api::client {

struct Account {
    ServerAddress server;
    std::string token;  // "" for a server that asks for none
};

using QueryParameters = std::vector<std::pair<std::string, std::string>>;

std::string percent_encode(std::string_view text);

// What the answer of a server means as an Error: its problem+json in our words.
Error error_of(const HttpResponse& response);

// How long a server may take to hash an archive of that size: 100 MB/s at least.
constexpr std::chrono::milliseconds hashing_timeout(std::int64_t archive_bytes) {
    return std::chrono::milliseconds(archive_bytes / 100'000);
}

// The Authorization header of an account; empty without a token.
std::vector<std::pair<std::string, std::string>> authorization(const Account& account);

// JSON in and out of the API. A status that is no success becomes the Error of that meaning; 429
// and 5xx are Error{Unavailable}.
class RestClient {
public:
    explicit RestClient(Account account);

    nlohmann::json get(const std::string& path, const QueryParameters& query = {});
    nlohmann::json post(const std::string& path,
                        const nlohmann::json& body,
                        std::chrono::milliseconds timeout = {});
    nlohmann::json patch(const std::string& path, const nlohmann::json& body);
    // The same with an Idempotency-Key, again until there is an answer: done once, however often
    // it is sent.
    nlohmann::json post_once(const std::string& path,
                             const nlohmann::json& body,
                             Backoff& backoff,
                             std::chrono::milliseconds timeout = {});
    std::string get_text(const std::string& path);
    void remove(const std::string& path);

    // All pages of a list, at most `limit` items.
    std::vector<nlohmann::json> list(const std::string& path,
                                     QueryParameters query,
                                     std::size_t limit = 10'000);

    const Account& account() const { return account_; }

private:
    HttpResponse send(HttpRequest request);
    nlohmann::json post(const std::string& path,
                        const nlohmann::json& body,
                        std::chrono::milliseconds timeout,
                        const std::string& idempotency_key);

    Account account_;
    HttpConnection connection_;
};

}  // namespace divemesh::api::client
