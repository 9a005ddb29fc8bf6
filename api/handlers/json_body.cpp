#include "api/handlers/json_body.hpp"

#include <algorithm>
#include <cctype>

#include "api/field_values.hpp"
#include "api/parse_json.hpp"
#include "api/target.hpp"
#include "schemas/json.hpp"
#include "schemas/wait_reason.hpp"

namespace divemesh::api {
namespace {

constexpr std::int64_t kMaxLimit = 200;

}  // namespace

std::string pointer_to(const std::string& key) {
    return (nlohmann::json::json_pointer() / key).to_string();
}

nlohmann::json json_body(const Request& request, const std::set<std::string>& known) {
    const std::string type = media_type_of(request.header("content-type"));
    const bool is_merge_patch =
        type == "application/merge-patch+json" && request.method == verb::patch;
    if (type != "application/json" && !is_merge_patch)
        throw Error(ErrorCode::Unsupported,
                    "the body has another content type: send Content-Type: application/json");
    auto body = parse_json(request.body);
    if (!body.is_object())
        throw Error(ErrorCode::InvalidArgument, "the body must be a JSON object");
    std::vector<Fault> faults;
    for (const auto& [key, value] : body.items())
        if (!known.contains(key))
            faults.push_back({"unknown key \"" + key + "\"", pointer_to(key), ""});
    if (!faults.empty()) throw InvalidInput(std::move(faults));
    return body;
}

storage::PageRequest page_request(const Request& request) {
    storage::PageRequest page;
    page.cursor = query_value(request, "cursor");
    const std::string order = query_value(request, "order");
    if (request.query.contains("order") && order != "oldest" && order != "newest")
        throw InvalidInput({{"order must be oldest or newest: which comes first", "", "order"}});
    page.newest_first = order == "newest";
    if (!request.query.contains("limit")) return page;
    const auto limit = parse_count(query_value(request, "limit"));
    if (!limit || *limit < 1 || *limit > kMaxLimit)
        throw InvalidInput({{"limit must be 1 to 200", "", "limit"}});
    page.limit = static_cast<int>(*limit);
    return page;
}

// The cursor is the number of values already returned.
Stretch stretch_of(const Request& request, std::size_t num_values) {
    const storage::PageRequest page = page_request(request);
    const auto before = parse_count(page.cursor.empty() ? "0" : page.cursor);
    if (!before || *before > static_cast<std::int64_t>(num_values))
        throw Error(
            ErrorCode::InvalidArgument,
            "this is not a cursor of this list: give next_cursor of the previous page unchanged");
    const auto first = static_cast<std::size_t>(*before);
    const std::size_t left = num_values - first;
    const std::size_t num = request.query.contains("limit")
                                ? std::min(left, static_cast<std::size_t>(page.limit))
                                : left;
    return {first, num, num < left ? std::to_string(first + num) : ""};
}

bool flag_value(const Request& request, const std::string& name) {
    const std::string value = query_value(request, name);
    if (value != "true" && value != "false" && request.query.contains(name))
        throw InvalidInput({{name + " must be true or false", "", name}});
    return value == "true";
}

std::string query_value(const Request& request, const std::string& name) {
    const auto found = request.query.find(name);
    return found == request.query.end() ? "" : found->second;
}

std::int64_t time_value(const Request& request, const std::string& name, std::int64_t otherwise) {
    if (!request.query.contains(name)) return otherwise;
    const auto value = parse_count(query_value(request, name));
    if (!value)
        throw Error(ErrorCode::InvalidArgument, name + " must be a time in Unix milliseconds");
    return *value;
}

template <>
nlohmann::json with_all_fields<ShownJob>() {
    ShownJob job;
    job.waits_for = to_string(WaitReason::Parent);
    job.deleted_at_ms = job.expires_at_ms = 1;
    return job;
}

template <>
nlohmann::json with_all_fields<Worker>() {
    Worker worker;
    worker.waits_for = to_string(WaitReason::Disk);
    return worker;
}

FieldChoice::FieldChoice(const std::string& list, const nlohmann::json& example) {
    for (const std::string& name : split_list(list)) {
        if (!example.contains(name))
            throw Error(ErrorCode::InvalidArgument,
                        "\"fields\" names \"" + name + "\", which does not exist");
        names_.push_back(name);
    }
}

nlohmann::json FieldChoice::leave(nlohmann::json whole) const {
    if (names_.empty()) return whole;
    nlohmann::json chosen = nlohmann::json::object();
    for (const std::string& name : names_)
        if (whole.contains(name)) chosen[name] = whole.at(name);
    return chosen;
}

Response secret_response(const nlohmann::json& created) {
    Response response = json_response(http::status::created, created);
    response.set("Cache-Control", "no-store");
    return response;
}

Response page_response(const Request& request,
                       nlohmann::json items,
                       const std::string& next_cursor,
                       nlohmann::json about) {
    about["items"] = std::move(items);
    about["next_cursor"] = next_cursor;
    Response response = json_response(http::status::ok, about);
    if (next_cursor.empty()) return response;
    auto query = request.query;
    query["cursor"] = next_cursor;
    response.set("Link", "<" + request.path + "?" + query_text(query) + ">; rel=\"next\"");
    return response;
}

}  // namespace divemesh::api
