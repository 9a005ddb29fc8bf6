#pragma once

#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace divemesh::io {

// Returns certificate.json as described by schemas/certificate.schema.json: which dive a result is
// of, what made it and how good it is, taken from its metrics.json. It states nothing of the run
// itself, such as times and threads: the same dive and options give the same bytes. Unknown values
// are left out. Throws Error{BadData} if a field of metrics.json has the wrong type.
nlohmann::json certificate_of(const nlohmann::json& metrics);

// Returns verdict and accuracy of a certificate as one line of printable ASCII, for the comments of
// files; at most 400 letters.
std::string certificate_line(const nlohmann::json& certificate);

// Returns when a recording began, by its own clock; nullopt if its timestamps do not count from
// 1970. Throws as certificate_of does.
std::optional<std::chrono::sys_seconds> recording_begin(const nlohmann::json& metrics);

}  // namespace divemesh::io
