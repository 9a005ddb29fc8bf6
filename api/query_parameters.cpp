#include "api/query_parameters.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "api/openapi_document.hpp"
#include "schemas/invalid_input.hpp"
#include "schemas/num_edits.hpp"

namespace divemesh::api {
namespace {

using nlohmann::json;
using Names = std::set<std::string>;

const json& resolved(const json& contract, const json& node) {
    if (!node.contains("$ref")) return node;
    return contract.at(json::json_pointer(node["$ref"].get<std::string>().substr(1)));
}

// Adds the query parameters that a path or an operation lists.
void add_listed(const json& contract, const json& node, Names& names) {
    const json parameters = node.value("parameters", json::array());
    for (const json& listed : parameters) {
        const json& parameter = resolved(contract, listed);
        if (parameter.at("in") == "query") names.insert(parameter.at("name"));
    }
}

// Adds the query parameters by which a caller may log in.
void add_credentials(const json& contract, const json& operation, Names& names) {
    const json& schemes = contract.at("components").at("securitySchemes");
    const json alternatives = operation.value("security", json::array());
    for (const json& alternative : alternatives)
        for (const auto& entry : alternative.items()) {
            const json& scheme = schemes.at(entry.key());
            if (scheme.value("in", "") == "query") names.insert(scheme.at("name"));
        }
}

Names names_of(const json& contract, const Route& route) {
    std::string path(route.path);
    if (const auto dots = path.find("...}"); dots != std::string::npos) path.erase(dots, 3);
    std::string method(http::to_string(route.method));
    for (char& c : method) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    const json& item = contract.at("paths").at(path);
    const json& operation = item.at(method);
    Names names;
    add_listed(contract, item, names);
    add_listed(contract, operation, names);
    add_credentials(contract, operation, names);
    return names;
}

std::map<const Route*, Names> names_of_routes() {
    const json contract = json::parse(openapi_json());
    std::map<const Route*, Names> names;
    for (const Route& route : api_routes()) names.emplace(&route, names_of(contract, route));
    return names;
}

// Returns the name with the fewest edits from `text`, unless a third of its characters are others;
// then "".
std::string nearest(const std::string& text, const Names& names) {
    std::string best;
    std::size_t least = (text.size() + 2) / 3 + 1;
    for (const std::string& name : names) {
        const std::size_t edits = num_edits(text, name);
        if (edits >= least) continue;
        least = edits;
        best = name;
    }
    return best;
}

std::string advice(const std::string& text, const Names& names) {
    if (names.empty()) return "; this address takes none";
    const std::string name = nearest(text, names);
    if (!name.empty()) return "; did you mean " + name + "?";
    std::string all;
    for (const std::string& known : names) all.append(all.empty() ? "" : ", ").append(known);
    return "; this address takes " + all;
}

}  // namespace

void require_known_query(const Request& request, const Route& route) {
    if (request.query.empty() || route.kind == RouteKind::Page) return;
    static const auto kNames = names_of_routes();
    const Names& names = kNames.at(&route);
    std::vector<Fault> faults;
    for (const auto& [name, value] : request.query)
        if (!names.contains(name))
            faults.push_back({"unknown parameter " + name + advice(name, names), "", name});
    if (!faults.empty()) throw InvalidInput(std::move(faults));
}

}  // namespace divemesh::api
