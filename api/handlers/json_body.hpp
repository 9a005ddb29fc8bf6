#pragma once

#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/http.hpp"
#include "schemas/invalid_input.hpp"
#include "storage/page.hpp"

namespace divemesh::api {

// Where a key of an object lies in it (RFC 6901).
std::string pointer_to(const std::string& key);

// The JSON object of a request. Throws Error{Unsupported} for another Content-Type,
// Error{InvalidArgument} for what is no object, and InvalidInput for keys beyond `known`.
nlohmann::json json_body(const Request& request, const std::set<std::string>& known);

// The value of a key that may be missing. Throws InvalidInput when it has another type.
template <typename T>
T value_or(const nlohmann::json& body, const std::string& key, T fallback) {
    const auto found = body.find(key);
    if (found == body.end()) return fallback;
    try {
        return found->get<T>();
    } catch (const nlohmann::json::exception&) {
        throw InvalidInput({{"\"" + key + "\" has the wrong type", pointer_to(key), ""}});
    }
}

// ?limit= and ?cursor=. Throws Error{InvalidArgument} when they are out of range.
storage::PageRequest page_request(const Request& request);

// ?name=, "" when it is missing.
std::string query_value(const Request& request, const std::string& name);
// True or false; without one false. Throws Error{InvalidArgument} for anything else.
bool flag_value(const Request& request, const std::string& name);

// ?name= in unix milliseconds, `otherwise` when it is missing. Throws Error{InvalidArgument}.
std::int64_t time_value(const Request& request, const std::string& name, std::int64_t otherwise);

// What ?fields=a,b leaves of objects: these alone, and all of them without it.
class FieldChoice {
public:
    // Of GET alone. Throws Error{InvalidArgument} that names the field which T does not have.
    template <typename T>
    static FieldChoice of(const Request& request) {
        const bool reads = request.method == verb::get || request.method == verb::head;
        if (!reads || !request.query.contains("fields")) return {};
        return FieldChoice(query_value(request, "fields"), T{});
    }

    nlohmann::json leave(nlohmann::json whole) const;

private:
    FieldChoice() = default;
    FieldChoice(const std::string& list, const nlohmann::json& example);

    std::vector<std::string> names_;  // empty: all
};

// {"items": [...], "next_cursor": "..."} and the link to the next page.
// `about`: what else there is to say of the list.
Response page_response(const Request& request,
                       nlohmann::json items,
                       const std::string& next_cursor,
                       nlohmann::json about = nlohmann::json::object());

// One object, and a page of them, with the fields that ?fields= leaves.
template <typename T>
Response resource_response(const Request& request, const T& value) {
    return json_response(http::status::ok, FieldChoice::of<T>(request).leave(value));
}

template <typename T>
Response list_response(const Request& request,
                       std::span<const T> values,
                       const std::string& next_cursor) {
    const auto choice = FieldChoice::of<T>(request);
    nlohmann::json items = nlohmann::json::array();
    for (const T& value : values) items.push_back(choice.leave(value));
    return page_response(request, std::move(items), next_cursor);
}

// Of a short list that was read as a whole: all of it unless ?limit= says otherwise.
struct Stretch {
    std::size_t first = 0;
    std::size_t num = 0;
    std::string next_cursor;  // "" at the end
};

Stretch stretch_of(const Request& request, std::size_t num_values);

template <typename T>
Response whole_list_response(const Request& request, const std::vector<T>& values) {
    const Stretch part = stretch_of(request, values.size());
    const auto shown = std::span(values).subspan(part.first, part.num);
    return list_response<T>(request, shown, part.next_cursor);
}

}  // namespace divemesh::api
