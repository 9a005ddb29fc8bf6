#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

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
    std::int64_t created_after_ms = -1;  // neither of the two included
    std::int64_t created_before_ms = std::numeric_limits<std::int64_t>::max();
    bool deleted = false;  // the deleted ones, else the others
};

// What a finished upload becomes a dive with.
struct NewDive {
    std::string upload_id;
    std::string project;
    std::string name;
    std::string archive_sha256;
    std::string content_sha256;  // "" when the client did not state it
    std::string blob;
    std::int64_t archive_bytes = 0;
    std::string preset;  // "": no reconstruction; else one is queued behind the intake job
    std::int64_t max_dives_of_project = 0;  // 0: no limit
};

// What the intake job found out about a dive.
struct IntakeResult {
    std::vector<Finding> findings;
    std::string name;  // "": keep
    std::string site;
    std::string rig;
    std::vector<std::string> tags;
    std::string content_sha256;
    std::int64_t num_frames = 0;
    double duration_s = 0.0;
    std::string thumbnail_blob;  // "": none
};

struct CreatedDive {
    Dive dive;
    bool existed = false;  // the same recording was here before: that dive is the answer
    std::string job_id;    // the reconstruction, "" when none was asked for
};

// The dives table with its findings.
class DiveStore {
public:
    explicit DiveStore(Catalog& catalog) : catalog_(catalog) {}

    // One transaction: the dive in state checking, its intake job, the reconstruction held behind
    // it when asked for, the upload bound to it, the events. Asked twice for one upload, it answers
    // the dive of the first time; a recording that is in the project already (archive or content
    // hash, not refused) makes no second dive. Throws Error{OutOfQuota}.
    CreatedDive create(const NewDive& dive);

    Dive get(const std::string& id);  // throws Error{NotFound}
    Page<Dive> list(const DiveFilter& filter, const PageRequest& page);
    std::vector<Finding> findings(const std::string& id);
    std::string thumbnail_blob(const std::string& id);  // throws Error{NotFound} when there is none

private:
    Catalog& catalog_;
};

}  // namespace divemesh::storage
