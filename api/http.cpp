#include "api/http.hpp"

#include <algorithm>
#include <ctime>
#include <nlohmann/json.hpp>

#include "schemas/error.hpp"

namespace divemesh::api {

std::string Request::header(std::string_view lower_case_name) const {
    const auto found = headers.find(lower_case_name);
    return found == headers.end() ? "" : found->second;
}

bool Request::has_header(std::string_view lower_case_name) const {
    return headers.find(lower_case_name) != headers.end();
}

const std::string& Request::parameter(std::string_view name) const {
    const auto found = parameters.find(name);
    if (found == parameters.end())
        throw std::logic_error("the route has no parameter " + std::string(name));
    return found->second;
}

void Response::set(std::string name, std::string value) {
    headers.emplace_back(std::move(name), std::move(value));
}

bool Response::has(std::string_view name) const {
    return std::any_of(headers.begin(), headers.end(), [name](const auto& header) {
        return header.first == name;
    });
}

void Response::add_vary(const std::string& name) {
    const auto known = std::find_if(
        headers.begin(), headers.end(), [](const auto& header) { return header.first == "Vary"; });
    if (known == headers.end()) return set("Vary", name);
    known->second += ", " + name;
}

// Names of a dive may hold any bytes, so invalid UTF-8 is replaced; it does not throw.
std::string json_text(const nlohmann::json& value) {
    return value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

Response json_response(http::status status, const nlohmann::json& body) {
    Response response{.status = status};
    response.set("Content-Type", "application/json");
    response.body = json_text(body);
    return response;
}

Response empty_response(http::status status) { return {.status = status}; }

std::string http_date(std::int64_t unix_s) {
    const std::time_t time = unix_s;
    std::tm parts{};
    gmtime_r(&time, &parts);
    char text[40];
    const std::size_t size = std::strftime(text, sizeof text, "%a, %d %b %Y %H:%M:%S GMT", &parts);
    return std::string(text, size);
}

}  // namespace divemesh::api
