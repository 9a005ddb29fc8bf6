#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "schemas/content_hash.hpp"
#include "schemas/dive.hpp"
#include "schemas/finding.hpp"
#include "schemas/job.hpp"
#include "storage/catalog.hpp"
#include "storage/page.hpp"

namespace divemesh::storage {

struct DiveFilter {
    std::string project;         // "": all projects (admin)
    std::string content_sha256;  // "": any
    std::string archive_sha256;  // "": any
    std::string site;            // "": any
    std::optional<DiveState> state;
    std::string tag;                     // "": any
    std::int64_t created_after_ms = -1;  // both ends excluded
    std::int64_t created_before_ms = std::numeric_limits<std::int64_t>::max();
    bool deleted = false;  // true: only deleted dives; false: only the others
};

// What a dive is created with from a finished upload.
struct NewDive {
    std::string upload_id;
    std::string project;
    std::string name;
    std::string archive_sha256;
    std::string content_sha256;  // "" if the client did not state it
    std::string blob;
    std::int64_t archive_bytes = 0;
    std::string preset;  // "": no reconstruction; otherwise one is queued after the intake job
    std::int64_t max_dives_of_project = 0;  // 0: no limit
};

// What the intake job has found out about a dive.
struct IntakeResult {
    std::vector<Finding> findings;
    std::string name;  // "": keep
    std::string site;
    std::string rig;
    std::vector<std::string> tags;
    std::string notes;
    std::optional<DivePosition> position;
    ContentHash content_sha256;
    std::int64_t num_frames = 0;
    double duration_s = 0.0;
    std::string thumbnail_blob;  // "": no thumbnail
};

struct CreatedDive {
    Dive dive;
    bool existed = false;  // true: the project already had this recording; `dive` is that dive
    std::string job_id;    // the reconstruction, "" if not requested
};

// The dives table with its findings.
class DiveStore {
public:
    explicit DiveStore(Catalog& catalog) : catalog_(catalog) {}

    // Creates in one transaction the dive in state checking, its intake job, the reconstruction
    // held behind it if requested, the upload's link to it, and the events. For the same upload
    // again it returns the first dive. A recording that the project has already (same archive or
    // content hash, not refused) makes no second dive. Throws Error{OutOfQuota}.
    CreatedDive create(const NewDive& dive);

    Dive get(const std::string& id);  // throws Error{NotFound}
    Page<Dive> list(const DiveFilter& filter, const PageRequest& page);
    std::vector<Finding> findings(const std::string& id);
    // Applies a merge patch (RFC 7396) to the description of a dive. What it sets to null is the
    // recording's again. Throws Error{NotFound}; Error{Conflict} while the intake reads the dive
    // and for a deleted dive.
    Dive edit(const std::string& id, const nlohmann::json& patch);
    std::string thumbnail_blob(const std::string& id);  // throws Error{NotFound} if it has none

private:
    Catalog& catalog_;
};

}  // namespace divemesh::storage
