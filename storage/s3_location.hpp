#pragma once

#include <string>

namespace divemesh::storage {

// Where the blobs are in an object store.
struct S3Location {
    std::string bucket;
    std::string prefix;    // of all keys: "" or ends with a slash
    std::string endpoint;  // scheme://host[:port]
    std::string region = "us-east-1";
    bool path_style =
        true;  // endpoint/bucket/key; otherwise the bucket is the first label of the host

    std::string host() const;                        // with the port; as in the header Host
    std::string path(const std::string& key) const;  // not encoded; of the bucket itself for ""
    std::string scheme() const;                      // "http" or "https"
    std::string text() const;                        // for messages
};

// Returns whether this is the URL of an object store.
bool is_s3_url(const std::string& url);

// Reads s3://bucket[/prefix]?endpoint=URL&region=NAME&style=path|host. Without an endpoint it is
// that of Amazon in the region. Throws Error{InvalidArgument}.
S3Location parse_s3_url(const std::string& url);

}  // namespace divemesh::storage
