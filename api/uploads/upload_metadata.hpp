#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "schemas/truth_file.hpp"

namespace divemesh::api {

// Parses Upload-Metadata of tus 1.0: "key base64,key base64,key". Throws Error{InvalidArgument} for
// a key that is empty, repeated or not printable ASCII, and for invalid base64.
std::map<std::string, std::string> parse_upload_metadata(std::string_view header);

// The keys that the server uses; it stores other keys but ignores them.
struct UploadPlan {
    std::string name;            // filename without folders and control characters; "" if missing
    std::string archive_sha256;  // "": not stated
    std::string content_sha256;  // "": not stated
    std::string preset;          // of the reconstruction to queue; "": no reconstruction
    bool commit = false;         // is made into its dive or truth as soon as it is complete
    std::optional<TruthKind> truth;  // truth of dive_id instead of a dive
    std::string dive_id;
};

// Throws Error{InvalidArgument} for a hash that is not 64 hex digits, an unknown preset or kind of
// truth, and truth without its dive.
UploadPlan plan_of(std::string_view header);

// Checks that `text` is a SHA-256 in lower-case hex. Throws Error{InvalidArgument}, which names
// `what`.
void check_sha256(const std::string& text, const std::string& what);

}  // namespace divemesh::api
