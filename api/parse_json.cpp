#include "api/parse_json.hpp"

#include <string>

#include "schemas/error.hpp"

namespace divemesh::api {
namespace {

constexpr int kMaxDepth = 32;  // deeper nesting is an attack on recursive code

}  // namespace

nlohmann::json parse_json(std::string_view text) {
    const auto shallow = [](int depth, nlohmann::json::parse_event_t, nlohmann::json&) {
        if (depth > kMaxDepth)
            throw Error(ErrorCode::InvalidArgument, "the body is nested too deeply");
        return true;
    };
    try {
        return nlohmann::json::parse(text, shallow);
    } catch (const nlohmann::json::exception& error) {
        throw Error(ErrorCode::InvalidArgument,
                    std::string("the body is not JSON: ") + error.what());
    }
}

}  // namespace divemesh::api
