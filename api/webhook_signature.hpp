#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace divemesh::api {

// Returns "whsec_" and the base64 of 32 random bytes, which are given as hex.
std::string webhook_secret(std::string_view random_hex);

// Returns the header webhook-signature of Standard Webhooks 1.0: "v1," and the base64 of
// HMAC-SHA256 over "id.timestamp.body", keyed with the secret's bytes.
std::string webhook_signature(std::string_view secret,
                              std::string_view id,
                              std::int64_t timestamp_s,
                              std::string_view body);

}  // namespace divemesh::api
