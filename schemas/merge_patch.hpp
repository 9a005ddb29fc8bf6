#pragma once

#include <nlohmann/json.hpp>

namespace divemesh {

// Returns the document without nulls in its objects, because a merge patch cannot set a null.
nlohmann::json without_nulls(nlohmann::json document);

// Returns the patch from `from` to `to` (RFC 7396). Neither may hold a null in an object.
nlohmann::json merge_patch(const nlohmann::json& from, const nlohmann::json& to);

}  // namespace divemesh
