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

// A server with the token for it.
struct Account {
    ServerAddress server;
    std::string token;  // "" for a server without authentication
    // How long what waits for the server goes on without an answer; 0: for ever.
    std::chrono::milliseconds give_up_after = std::chrono::minutes(10);
};

using QueryParameters = std::vector<std::pair<std::string, std::string>>;

// Escapes all but unreserved characters (RFC 3986), for a path or a query.
std::string percent_encode(std::string_view text);

// Return the path of a job, of a dive.
std::string job_path(std::string_view job_id);
std::string dive_path(std::string_view dive_id);

// Returns the Error that a server's response means, made from its problem+json.
Error error_of(const HttpResponse& response);

// Returns how long a server may take to hash an archive of that size: 100 MB/s at least.
constexpr std::chrono::milliseconds hashing_timeout(std::int64_t archive_bytes) {
    return std::chrono::milliseconds(archive_bytes / 100'000);
}

// Returns the Authorization header of an account; empty without a token.
std::vector<std::pair<std::string, std::string>> authorization(const Account& account);

// Sends and receives JSON over the API. An unsuccessful status is thrown as the Error of that
// meaning; 429 and 5xx are Error{Unavailable}.
class RestClient {
public:
    explicit RestClient(Account account);

    nlohmann::json get(const std::string& path, const QueryParameters& query = {});
    nlohmann::json post(const std::string& path,
                        const nlohmann::json& body,
                        std::chrono::milliseconds timeout = {});
    nlohmann::json patch(const std::string& path, const nlohmann::json& body);
    // Posts with an Idempotency-Key and retries until there is an answer. The server does the work
    // once, however often the request is sent.
    nlohmann::json post_once(const std::string& path,
                             const nlohmann::json& body,
                             Backoff& backoff,
                             std::chrono::milliseconds timeout = {});
    std::string get_text(const std::string& path);
    void remove(const std::string& path);

    // Returns the items of all pages of a list, `limit` at most.
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
