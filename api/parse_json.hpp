#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

namespace divemesh::api {

// Parses JSON. Throws Error{InvalidArgument} for invalid JSON or too deep nesting, and InvalidInput
// for an object with a key that occurs twice.
nlohmann::json parse_json(std::string_view text);

}  // namespace divemesh::api
