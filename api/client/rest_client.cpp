#include "api/client/rest_client.hpp"

#include <cctype>
#include <random>

#include "schemas/error.hpp"

namespace divemesh::api::client {
namespace {

constexpr std::chrono::seconds kStall{60};

ErrorCode code_of(int status) {
    switch (status) {
        case 400: return ErrorCode::InvalidArgument;
        case 401: return ErrorCode::Unauthorized;
        case 403: return ErrorCode::Forbidden;
        case 404:
        case 410: return ErrorCode::NotFound;
        case 409: return ErrorCode::Conflict;
        case 412:
        case 415: return ErrorCode::Unsupported;
        case 413: return ErrorCode::TooLarge;
        case 422: return ErrorCode::BadData;
        case 507: return ErrorCode::OutOfSpace;
        default:
            return status == 423 || status == 429 || status >= 500 ? ErrorCode::Unavailable
                                                                   : ErrorCode::InvalidArgument;
    }
}

// Returns whether a conflict will pass by itself: an earlier request of this client is still under
// way.
bool is_to_wait(const HttpResponse& response) {
    return response.status == 409 && !response.header("retry-after").empty();
}

std::string text_of(const nlohmann::json& problem, const char* key) {
    if (!problem.is_object()) return "";
    const auto found = problem.find(key);
    return found != problem.end() && found->is_string() ? found->get<std::string>() : "";
}

std::string query_text(const QueryParameters& query) {
    std::string text;
    for (const auto& [name, value] : query)
        text += (text.empty() ? "?" : "&") + name + "=" + percent_encode(value);
    return text;
}

std::string random_key() {
    std::random_device random;
    std::string key;
    for (int i = 0; i < 4; ++i) key += std::to_string(random()) + (i < 3 ? "-" : "");
    return key;
}

}  // namespace

std::string percent_encode(std::string_view text) {
    constexpr char kDigits[] = "0123456789ABCDEF";
    std::string result;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (std::isalnum(byte) != 0 || c == '-' || c == '.' || c == '_' || c == '~') {
            result += c;
        } else {
            result += '%';
            result += kDigits[byte >> 4];
            result += kDigits[byte & 15];
        }
    }
    return result;
}

std::string job_path(std::string_view job_id) { return "/api/v1/jobs/" + percent_encode(job_id); }

std::string dive_path(std::string_view dive_id) {
    return "/api/v1/dives/" + percent_encode(dive_id);
}

Error error_of(const HttpResponse& response) {
    std::string message = "the server answered " + std::to_string(response.status);
    const auto problem = nlohmann::json::parse(response.body, nullptr, false);
    for (const char* key : {"detail", "title"}) {
        const std::string text = text_of(problem, key);
        if (text.empty()) continue;
        message += ": " + text;
        break;
    }
    if (response.status == 401) message += " (give a token with DIVEMESH_TOKEN or --token-file)";
    return Error(is_to_wait(response) ? ErrorCode::Unavailable : code_of(response.status), message);
}

std::vector<std::pair<std::string, std::string>> authorization(const Account& account) {
    if (account.token.empty()) return {};
    return {{"Authorization", "Bearer " + account.token}};
}

RestClient::RestClient(Account account)
    : account_(std::move(account)), connection_(account_.server, kStall) {}

HttpResponse RestClient::send(HttpRequest request) {
    for (auto& header : authorization(account_)) request.headers.push_back(std::move(header));
    HttpResponse response = connection_.send(request);
    if (response.status < 200 || response.status > 299) throw error_of(response);
    return response;
}

nlohmann::json RestClient::get(const std::string& path, const QueryParameters& query) {
    return nlohmann::json::parse(send({"GET", path + query_text(query), {}, ""}).body);
}

nlohmann::json RestClient::post(const std::string& path,
                                const nlohmann::json& body,
                                std::chrono::milliseconds timeout) {
    return post(path, body, timeout, "");
}

nlohmann::json RestClient::post(const std::string& path,
                                const nlohmann::json& body,
                                std::chrono::milliseconds timeout,
                                const std::string& idempotency_key) {
    HttpRequest request{"POST", path, {{"Content-Type", "application/json"}}, body.dump(), timeout};
    if (!idempotency_key.empty()) request.headers.emplace_back("Idempotency-Key", idempotency_key);
    const auto response = send(std::move(request));
    return response.body.empty() ? nlohmann::json() : nlohmann::json::parse(response.body);
}

nlohmann::json RestClient::patch(const std::string& path, const nlohmann::json& body) {
    return nlohmann::json::parse(
        send({"PATCH", path, {{"Content-Type", "application/json"}}, body.dump()}).body);
}

nlohmann::json RestClient::post_once(const std::string& path,
                                     const nlohmann::json& body,
                                     Backoff& backoff,
                                     std::chrono::milliseconds timeout) {
    const std::string key = random_key();
    return backoff.until_done([&] { return post(path, body, timeout, key); });
}

std::string RestClient::get_text(const std::string& path) {
    return send({"GET", path, {}, ""}).body;
}

void RestClient::remove(const std::string& path) { send({"DELETE", path, {}, ""}); }

std::vector<nlohmann::json> RestClient::list(const std::string& path,
                                             QueryParameters query,
                                             std::size_t limit) {
    std::vector<nlohmann::json> items;
    while (true) {
        const auto page = get(path, query);
        for (const auto& item : page.at("items")) {
            if (items.size() == limit) return items;
            items.push_back(item);
        }
        const std::string cursor = page.value("next_cursor", "");
        if (cursor.empty()) return items;
        std::erase_if(query, [](const auto& parameter) { return parameter.first == "cursor"; });
        query.emplace_back("cursor", cursor);
    }
}

}  // namespace divemesh::api::client
