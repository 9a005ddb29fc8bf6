#pragma once

#include <optional>
#include <string>
#include <vector>

#include "schemas/upload.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

// Limits of a project or a token; 0: no limit.
struct UploadLimits {
    std::int64_t max_bytes_of_project = 0;  // including its dives
    std::int64_t max_open_of_project = 0;   // incomplete uploads, or complete but not yet a dive
    std::int64_t max_open_of_token = 0;
};

// The uploads table. The bytes are in the blob store's staging area; a row's offset is what the
// server has made durable there. An ended upload is remembered for a while, so that its client
// learns about it.
class UploadStore {
public:
    explicit UploadStore(Catalog& catalog) : catalog_(catalog) {}

    // Creates an upload and sets its `id`, `blob` and times. Throws Error{OutOfQuota},
    // Error{TooMany}; simultaneous requests cannot exceed the limits together. Event
    // upload.created.
    Upload create(Upload upload, const UploadLimits& limits = {});
    // Creates a final upload. It has the bytes of its parts, which count already, except parts that
    // it names twice or that another final upload under way has claimed. The same parts and
    // metadata again return the same upload. Throws Error{Gone} for a part that ended meanwhile,
    // and as create().
    Upload create_final(Upload upload,
                        const std::vector<std::string>& part_ids,
                        const UploadLimits& limits = {});
    // Returns the final upload of exactly these parts and metadata, if there is one.
    std::optional<Upload> find_final(const Upload& wanted);
    Upload get(const std::string& id);  // throws Error{NotFound}; returns ended ones, too
    std::optional<Upload> find(const std::string& id);  // the same, but nullopt if there is none
    // Sets the length that was left open at creation. The same value again changes nothing. Throws
    // Error{InvalidArgument} for another value, or one below the offset, Error{OutOfQuota}. Event
    // upload.completed if the offset is there already.
    Upload set_length(const std::string& id,
                      std::int64_t length_bytes,
                      std::int64_t max_bytes_of_project = 0);
    // Moves the offset forward, never back: a lower or equal value changes nothing. Event
    // upload.completed when it reaches the length.
    Upload advance(const std::string& id, std::int64_t offset_bytes);

    // Throws Error{NotFound}, Error{Gone}, and Error{Locked} for a part that is being concatenated.
    void end(const std::string& id, UploadEnd end);
    bool expire(const std::string& id);  // false: not due, being concatenated, or already gone
    std::vector<std::string> list_expired();
    std::vector<Upload> list_unfreed();  // ended uploads with bytes still on disk
    void set_freed(const std::string& id);
    void forget_ended(std::int64_t older_than_ms);

    std::vector<Upload> list_open();  // neither ended nor a dive

private:
    Catalog& catalog_;
};

// Throws Error{Gone}, which says how the upload ended, unless it is open.
void require_open(const Upload& upload);

}  // namespace divemesh::storage
