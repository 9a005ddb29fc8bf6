#pragma once

#include <nlohmann/json.hpp>

namespace divemesh {

// Without what is null in its objects: a merge patch cannot say that something is null.
nlohmann::json without_nulls(nlohmann::json document);

// What makes `to` of `from` (RFC 7396). Neither holds a null in an object.
nlohmann::json merge_patch(const nlohmann::json& from, const nlohmann::json& to);

}  // namespace divemesh
