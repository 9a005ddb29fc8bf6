#pragma once

#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "api/http.hpp"
#include "schemas/error.hpp"
#include "storage/page.hpp"

namespace divemesh::api {

// The JSON object of a request. Throws Error{Unsupported} for another Content-Type and
// Error{InvalidArgument} for what is no object or has keys beyond `known`.
nlohmann::json json_body(const Request& request, const std::set<std::string>& known);

// The value of a key that may be missing. Throws Error{InvalidArgument} when it has another type.
template <typename T>
T value_or(const nlohmann::json& body, const std::string& key, T fallback) {
    const auto found = body.find(key);
    if (found == body.end()) return fallback;
    try {
        return found->get<T>();
    } catch (const nlohmann::json::exception&) {
        throw Error(ErrorCode::InvalidArgument, "\"" + key + "\" has the wrong type");
    }
}

// ?limit= and ?cursor=. Throws Error{InvalidArgument} when they are out of range.
storage::PageRequest page_request(const Request& request);

// ?name=, "" when it is missing.
std::string query_value(const Request& request, const std::string& name);

// ?name= in unix milliseconds, `otherwise` when it is missing. Throws Error{InvalidArgument}.
std::int64_t time_value(const Request& request, const std::string& name, std::int64_t otherwise);

// {"items": [...], "next_cursor": "..."} and the link to the next page.
Response list_response(const Request& request,
                       nlohmann::json items,
                       const std::string& next_cursor = "");

}  // namespace divemesh::api
