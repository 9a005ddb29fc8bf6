#pragma once

#include <filesystem>
#include <string>

#include "storage/sigv4.hpp"

namespace divemesh::storage {

// Returns the keys of AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY and AWS_SESSION_TOKEN, otherwise
// those in the file AWS_SHARED_CREDENTIALS_FILE (~/.aws/credentials) under the name AWS_PROFILE
// (default). Throws Error{InvalidArgument} if there are none.
S3Credentials find_s3_credentials();

// Reads the keys under [profile] of such a file. Throws Error{InvalidArgument}.
S3Credentials read_s3_credentials(const std::filesystem::path& file, const std::string& profile);

}  // namespace divemesh::storage
