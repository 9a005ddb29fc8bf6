#pragma once

#include <optional>
#include <string>
#include <vector>

#include "schemas/upload.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

// The uploads table. The bytes are in the blob store's staging area; a row's offset is what the
// server has made durable there.
class UploadStore {
public:
    explicit UploadStore(Catalog& catalog) : catalog_(catalog) {}

    // `upload.id`, `blob` and the times are set here. Event upload.created.
    Upload create(Upload upload);
    Upload get(const std::string& id);  // throws Error{NotFound}
    // Moves the offset forward, never back: a lower or equal value changes nothing.
    // Event upload.completed when it reaches the length.
    Upload advance(const std::string& id, std::int64_t offset_bytes);
    void remove(const std::string& id);  // throws Error{NotFound}
    // For sweeping: no dive came of them, and they were neither created nor advanced since then.
    std::vector<Upload> list_older_than(std::int64_t touched_before_ms);

private:
    Catalog& catalog_;
};

}  // namespace divemesh::storage
