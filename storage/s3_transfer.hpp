#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "schemas/file_descriptor.hpp"
#include "storage/s3_client.hpp"

namespace divemesh::storage {

// Returns the size of the parts in which an object of this size is written: `usual_bytes` (at least
// 5 MiB), or what makes them 10,000. Throws Error{TooLarge} for what is more than an object may be.
std::int64_t part_bytes_of(std::int64_t size_bytes, std::int64_t usual_bytes);

// Writes the whole of an open file as an object, which others see whole or not at all. Parts go
// over several connections. After a failure nothing of it stays in the store, unless the store
// cannot be reached: then abort_uploads_before() removes it
// later.
void send_file(S3Client& client, const std::string& key, const FileDescriptor& file);

// Writes an object to a file, in ranges over several connections. The file is whole if the call
// returns.
void fetch_file(S3Client& client,
                const std::string& key,
                const S3Object& object,
                const std::filesystem::path& file);

// Removes the parts of uploads that began before a time: what killed programs have left.
void abort_uploads_before(S3Client& client, const std::string& prefix, std::time_t time);

}  // namespace divemesh::storage
