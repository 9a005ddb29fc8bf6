#pragma once

#include <optional>
#include <string>
#include <vector>

#include "schemas/upload.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

// How much a project or a token may have; 0: no limit.
struct UploadLimits {
    std::int64_t max_bytes_of_project = 0;  // with its dives
    std::int64_t max_open_of_project = 0;   // uploads that are not complete or no dive yet
    std::int64_t max_open_of_token = 0;
};

// The uploads table. The bytes are in the blob store's staging area; a row's offset is what the
// server has made durable there. An upload that ended is remembered for a while, so that its client
// learns so.
class UploadStore {
public:
    explicit UploadStore(Catalog& catalog) : catalog_(catalog) {}

    // `upload.id`, `blob` and the times are set here. Throws Error{OutOfQuota}, Error{TooMany}: of
    // several that come at once none goes beyond the limits. Event upload.created.
    Upload create(Upload upload, const UploadLimits& limits = {});
    // A final upload has the bytes of its parts, which count already: all but those that it names
    // again or that another final upload under way has claimed. The same parts and metadata again
    // are the same upload. Throws Error{Gone} for a part that ended meanwhile, and as create().
    Upload create_final(Upload upload,
                        const std::vector<std::string>& part_ids,
                        const UploadLimits& limits = {});
    // The final upload of these very parts and metadata, when it was made before.
    std::optional<Upload> find_final(const Upload& wanted);
    Upload get(const std::string& id);  // throws Error{NotFound}; one that ended is told too
    std::optional<Upload> find(const std::string& id);  // the same, nothing when there is none
    // Tells the length that was left open at creation. The same again changes nothing. Throws
    // Error{InvalidArgument} for another one, or one below the offset, Error{OutOfQuota}. Event
    // upload.completed when the offset is there already.
    Upload set_length(const std::string& id,
                      std::int64_t length_bytes,
                      std::int64_t max_bytes_of_project = 0);
    // Moves the offset forward, never back: a lower or equal value changes nothing.
    // Event upload.completed when it reaches the length.
    Upload advance(const std::string& id, std::int64_t offset_bytes);

    // Throws Error{NotFound}, Error{Gone}, and Error{Locked} for a part that is being joined.
    void end(const std::string& id, UploadEnd end);
    bool expire(const std::string& id);  // false: it is not due, being joined, or is no more
    std::vector<std::string> list_expired();
    std::vector<Upload> list_unfreed();  // ended, and their bytes are still on disk
    void set_freed(const std::string& id);
    void forget_ended(std::int64_t older_than_ms);

    std::vector<Upload> list_open();  // neither ended nor a dive

private:
    Catalog& catalog_;
};

// Throws Error{Gone} that says how the upload ended.
void require_open(const Upload& upload);

}  // namespace divemesh::storage
