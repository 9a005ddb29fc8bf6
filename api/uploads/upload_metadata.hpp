#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "schemas/truth_file.hpp"

namespace divemesh::api {

// Upload-Metadata of tus 1.0: "key base64,key base64,key". Throws Error{InvalidArgument} for an
// empty or repeated key, one that is not printable ASCII, and what is not base64.
std::map<std::string, std::string> parse_upload_metadata(std::string_view header);

// What we make of it; other keys are kept and mean nothing.
struct UploadPlan {
    std::string name;            // filename without folders and control characters; "" when unnamed
    std::string archive_sha256;  // "": not stated
    std::string content_sha256;  // "": not stated
    std::string preset;          // of the reconstruction to queue; "": none
    bool commit = false;         // becomes what it is as soon as it is complete
    std::optional<TruthKind> truth;  // no dive, but truth of dive_id
    std::string dive_id;
};

// Throws Error{InvalidArgument} for a hash that is not 64 hex digits, an unknown preset or kind of
// truth, and truth that does not say of which dive.
UploadPlan plan_of(std::string_view header);

// Lower-case hex of a SHA-256. Throws Error{InvalidArgument} that names `what`.
void check_sha256(const std::string& text, const std::string& what);

}  // namespace divemesh::api
