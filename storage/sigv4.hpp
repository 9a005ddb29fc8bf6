#pragma once

#include <map>
#include <string>
#include <string_view>

namespace divemesh::storage {

// The keys by which an object store knows its user. The token belongs to temporary keys, else "".
struct S3Credentials {
    std::string access_key;
    std::string secret_key;
    std::string session_token;
};

// What of a request is signed. Names of headers are in lower case; path and query are not yet
// encoded.
struct SignedParts {
    std::string method;
    std::string path;  // begins with a slash
    std::map<std::string, std::string> query;
    std::map<std::string, std::string> headers;  // all of them are signed; "host" is among them
};

std::string to_hex(std::string_view bytes);  // in lower case

// Encodes every byte but A-Z a-z 0-9 - . _ ~ as %XX; a slash stays if `keep_slash`.
std::string percent_encoded(std::string_view text, bool keep_slash = false);

// Returns the query as it stands in a URL and is signed: sorted by name, "" without parameters.
std::string canonical_query(const std::map<std::string, std::string>& query);

// Returns the header Authorization of AWS Signature Version 4 for the service s3. `time` is that of
// the header x-amz-date (20130524T000000Z), `payload_sha256` that of x-amz-content-sha256.
std::string sigv4_authorization(const SignedParts& parts,
                                const S3Credentials& credentials,
                                const std::string& region,
                                const std::string& time,
                                const std::string& payload_sha256);

}  // namespace divemesh::storage
