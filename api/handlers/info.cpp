#include "api/handlers/info.hpp"

#include <nlohmann/json.hpp>

#include "api/handlers/json_body.hpp"
#include "api/openapi_document.hpp"
#include "api/read_nonblocking.hpp"
#include "api/uploads/tus_headers.hpp"
#include "api/uploads/upload_checksum.hpp"
#include "schemas/option_range.hpp"
#include "schemas/reconstruction_options.hpp"
#include "storage/data_id.hpp"
#include "storage/engine_name.hpp"

namespace divemesh::api {
namespace {

using nlohmann::json;

// A "max_" of 0 means no limit.
json limits_to_json(const ServiceLimits& limits) {
    const auto seconds = [](std::chrono::milliseconds time) { return time.count() / 1000; };
    return {{"max_body_bytes", kMaxBodyBytes},
            {"max_upload_bytes", limits.max_upload_bytes},
            {"max_open_uploads", limits.max_open_uploads},
            {"max_token_uploads", limits.max_token_uploads},
            {"max_project_bytes", limits.max_project_bytes},
            {"max_project_dives", limits.max_project_dives},
            {"min_free_bytes", limits.min_free_bytes},
            {"min_upload_bytes_per_s", limits.min_upload_bytes_per_s},
            {"upload_lifetime_s", seconds(limits.upload_lifetime)},
            {"keep_deleted_s", seconds(limits.keep_deleted)}};
}

// Returns an option of a report or a comparison as describe_options() has those of a
// reconstruction, from the contract's schema of it.
json option_of(const std::string& name, const json& schema) {
    OptionRange range;
    if (schema.contains("minimum")) range.min = schema["minimum"].get<double>();
    if (schema.contains("maximum")) range.max = schema["maximum"].get<double>();
    json option = range_to_json(range);
    option["name"] = name;
    option["type"] = schema.at("type");
    option["unit"] = unit_in_name(name);
    option["help"] = schema.at("description");
    option["defaults"] = json::object();
    return option;
}

json options_of(const json& schema) {
    json options = json::array();
    for (const auto& [name, property] : schema.at("properties").items())
        options.push_back(option_of(name, property));
    return options;
}

json options_of_kinds() {
    const json contract = json::parse(openapi_json());
    const json& schemas = contract.at("components").at("schemas");
    return {{{"kind", "reconstruct"}, {"presets", kPresets}, {"options", describe_options()}},
            {{"kind", "accuracy_report"},
             {"presets", json::array()},
             {"options", options_of(schemas.at("ReportOptions"))}},
            {{"kind", "compare"},
             {"presets", json::array()},
             {"options", options_of(schemas.at("CompareOptions"))}}};
}

}  // namespace

Awaitable<Response> get_info(Request, Services services) {
    const std::string engine = co_await read_nonblocking(services, storage::engine_name);
    const std::string data_id = co_await read_nonblocking(services, storage::data_id);
    const json info = {
        {"version", DIVEMESH_VERSION},
        {"engine", engine},
        {"data_id", data_id},
        {"tus", {{"extensions", kTusExtensions}, {"checksums", kChecksumAlgorithms}}},
        {"limits", limits_to_json(services.limits)}};
    co_return json_response(http::status::ok, info);
}

Awaitable<Response> get_options(Request, Services) {
    static const json kOptions = {{"items", options_of_kinds()}};
    co_return json_response(http::status::ok, kOptions);
}

}  // namespace divemesh::api
