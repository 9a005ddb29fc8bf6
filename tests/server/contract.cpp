#include "tests/server/contract.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <sstream>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "api/openapi_document.hpp"
#include "api/router.hpp"
#include "api/target.hpp"

namespace divemesh {
namespace {

using nlohmann::json;
using Adapter = valijson::adapters::NlohmannJsonAdapter;

const json& contract() {
    static const json document = json::parse(api::openapi_json());
    return document;
}

const json& resolved(const json& node) {
    if (!node.contains("$ref")) return node;
    const auto target = node["$ref"].get<std::string>();
    return contract().at(json::json_pointer(target.substr(1)));
}

std::string lower(std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

const api::Route* route_of(const std::string& method, const std::string& target) {
    const auto verb = api::http::string_to_verb(method);
    return api::find_route(verb, target.substr(0, target.find('?'))).route;
}

bool is_of_page(const api::Route* route) {
    return route != nullptr && route->kind == api::RouteKind::Page;
}

// The documented operation, null when there is none.
const json* operation_of(const api::Route* route) {
    if (route == nullptr || is_of_page(route)) return nullptr;
    std::string path(route->path);
    if (const auto dots = path.find("...}"); dots != std::string::npos) path.erase(dots, 3);
    const auto& item = contract().at("paths").at(path);
    const auto name = lower(std::string(api::http::to_string(route->method)));
    return &item.at(name);
}

bool takes_fields(const json& operation) {
    const auto parameters = operation.value("parameters", json::array());
    return std::any_of(parameters.begin(), parameters.end(), [](const json& parameter) {
        return parameter.value("$ref", "") == "#/components/parameters/Fields";
    });
}

std::string fields_of(const std::string& target) {
    const auto query = api::parse_target(target).query;
    const auto found = query.find("fields");
    return found == query.end() ? "" : found->second;
}

std::unique_ptr<valijson::Schema> parsed(const json& node) {
    auto schema = std::make_unique<valijson::Schema>();
    const json rooted = {{"allOf", {node}}, {"components", contract().at("components")}};
    valijson::SchemaParser().populateSchema(Adapter(rooted), *schema);
    return schema;
}

// The compiled schema of the node, which has to live as long as the document.
const valijson::Schema& compiled(const json& node) {
    static std::mutex mutex;
    static std::map<const json*, std::unique_ptr<valijson::Schema>> schemas;
    const std::lock_guard lock(mutex);
    auto& schema = schemas[&node];
    if (!schema) schema = parsed(node);
    return *schema;
}

// The schema of an answer to ?fields=: of the object, or each of the list, these and no others.
json with_fields_alone(const json& schema, const std::string& names) {
    json whole = resolved(schema);
    if (whole["properties"].contains("next_cursor")) {
        auto& items = whole["properties"]["items"]["items"];
        items = with_fields_alone(items, names);
        return whole;
    }
    json sparse = {{"type", "object"}, {"additionalProperties", false}};
    std::istringstream list(names);
    for (std::string name; std::getline(list, name, ',');) {
        sparse["required"].push_back(name);
        sparse["properties"][name] = whole.at("properties").at(name);
    }
    return sparse;
}

std::string breach_of(const valijson::Schema& schema, const json& value) {
    valijson::ValidationResults results;
    if (valijson::Validator().validate(schema, Adapter(value), &results)) return "";
    std::string text;
    for (valijson::ValidationResults::Error error; results.popError(error);) {
        for (const auto& step : error.context) text += step;
        text += ": " + error.description + "; ";
    }
    return text;
}

std::string body_breach(const json& content,
                        const std::string& fields,
                        const RawResponse& response) {
    const std::string type = response.header("content-type");
    const std::string plain = type.substr(0, type.find(';'));
    auto found = content.find(plain);
    if (found == content.end()) found = content.find("application/octet-stream");  // any bytes
    if (found == content.end()) return "the content type \"" + type + "\" is not documented";
    if (plain.find("json") == std::string::npos || found.key() != plain ||
        response.headers.contains("content-encoding"))
        return "";
    const json body = json::parse(response.body, nullptr, false);
    if (body.is_discarded()) return "the body is not JSON";
    const json& schema = found->at("schema");
    return breach_of(fields.empty() ? compiled(schema) : *parsed(with_fields_alone(schema, fields)),
                     body);
}

std::string header_breach(const json& headers, const RawResponse& response) {
    for (const auto& [name, header] : headers.items())
        if (resolved(header).value("required", false) && !response.headers.contains(lower(name)))
            return "the header " + name + " is missing";
    return "";
}

std::string answer_breach(const json& documented,
                          bool head,
                          const std::string& fields,
                          const RawResponse& response) {
    if (documented.contains("headers")) {
        auto breach = header_breach(documented["headers"], response);
        if (!breach.empty()) return breach;
    }
    if (head) return "";
    if (documented.contains("content")) return body_breach(documented["content"], fields, response);
    return response.body.empty() ? "" : "a body is not documented";
}

}  // namespace

std::string contract_breach(const std::string& method,
                            const std::string& target,
                            const RawResponse& response) {
    if (!response.headers.contains("x-request-id")) return "the header X-Request-Id is missing";
    const json& problem = contract().at("components").at("responses").at("Problem");
    // The answer to a preflight is that of CORS, not of an operation.
    if (method == "OPTIONS" && response.headers.contains("access-control-allow-methods")) return "";
    const api::Route* route = route_of(method, target);
    if (is_of_page(route) && response.status < 400) return "";
    const json* operation = operation_of(route);
    if (operation == nullptr)
        return response.status < 400 ? "nothing is documented here"
                                     : answer_breach(problem, method == "HEAD", "", response);
    const json& responses = operation->at("responses");
    const bool sparse = response.status == 200 && takes_fields(*operation);
    const std::string fields = sparse ? fields_of(target) : "";
    const auto exact = responses.find(std::to_string(response.status));
    if (exact != responses.end())
        return answer_breach(resolved(*exact), method == "HEAD", fields, response);
    if (response.status < 400) return "the status is not documented";
    return answer_breach(problem, method == "HEAD", "", response);
}

}  // namespace divemesh
