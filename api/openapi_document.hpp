#pragma once

#include <string_view>

namespace divemesh::api {

// Returns api/openapi.yaml as JSON, converted when the program was built.
std::string_view openapi_json();

}  // namespace divemesh::api
