#pragma once

#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/http.hpp"
#include "schemas/invalid_input.hpp"
#include "schemas/shown_job.hpp"
#include "schemas/worker.hpp"
#include "storage/page.hpp"

namespace divemesh::api {

// Returns the JSON pointer (RFC 6901) to a key of an object.
std::string pointer_to(const std::string& key);

// Returns the JSON object of a request; for PATCH it may be a merge patch (RFC 7396). Throws
// Error{Unsupported} for another Content-Type,
// Error{InvalidArgument} if it is not an object, and InvalidInput for keys outside `known`.
nlohmann::json json_body(const Request& request, const std::set<std::string>& known);

// Returns the value of a key; `fallback` if it is missing. Throws InvalidInput if it has another
// type.
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

// Returns ?limit= and ?cursor=. Throws Error{InvalidArgument} if they are out of range.
storage::PageRequest page_request(const Request& request);

// Returns ?name=, "" if it is missing.
std::string query_value(const Request& request, const std::string& name);
// Returns ?name= as true or false; false if it is missing. Throws Error{InvalidArgument} for other
// values.
bool flag_value(const Request& request, const std::string& name);

// Returns ?name= in unix milliseconds, `otherwise` if it is missing. Throws Error{InvalidArgument}.
std::int64_t time_value(const Request& request, const std::string& name, std::int64_t otherwise);

// Returns an object with every field that T may have.
template <typename T>
nlohmann::json with_all_fields() {
    return T{};
}
template <>
nlohmann::json with_all_fields<ShownJob>();
template <>
nlohmann::json with_all_fields<Worker>();

// The fields of objects that ?fields=a,b selects; all fields without it. A field that an object
// does not have stays absent.
class FieldChoice {
public:
    // Reads ?fields= of GET and HEAD only. Throws Error{InvalidArgument}, which names the field
    // that T lacks.
    template <typename T>
    static FieldChoice of(const Request& request) {
        const bool reads = request.method == verb::get || request.method == verb::head;
        if (!reads || !request.query.contains("fields")) return {};
        return FieldChoice(query_value(request, "fields"), with_all_fields<T>());
    }

    nlohmann::json leave(nlohmann::json whole) const;

private:
    FieldChoice() = default;
    FieldChoice(const std::string& list, const nlohmann::json& example);

    std::vector<std::string> names_;  // empty: all
};

// Returns {"items": [...], "next_cursor": "..."} with a link to the next page. `about`: further
// members of the response.
Response page_response(const Request& request,
                       nlohmann::json items,
                       const std::string& next_cursor,
                       nlohmann::json about = nlohmann::json::object());

// Returns the object that was created, which holds a secret: no cache may keep it.
Response secret_response(const nlohmann::json& created);

// Returns one object, or a page of objects, with the fields that ?fields= selects.
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

// The range of a short list that is returned: all of it unless ?limit= says otherwise.
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
