#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

namespace divemesh::api {

// Throws Error{InvalidArgument} for what is not JSON, or is nested too deeply.
nlohmann::json parse_json(std::string_view text);

}  // namespace divemesh::api
