#pragma once

#include <optional>
#include <soci/soci.h>
#include <string>

#include "schemas/dive.hpp"
#include "schemas/job.hpp"
#include "storage/dive_store.hpp"

// Read and change dives inside a transaction.
namespace divemesh::storage {

struct DiveRow {
    Dive dive;
    std::string state;
    std::string tags;
    std::string position;
    std::string recorded;
    int has_thumbnail = 0;

    void define(soci::statement& statement);
    Dive value() const;
};

inline constexpr const char* kDiveColumns =
    "id, project, state, name, site, rig, tags, notes, position, recorded, archive_sha256,"
    " content_sha256, archive_bytes, blob,"
    " num_frames, duration_s, CASE WHEN thumbnail_blob = '' THEN 0 ELSE 1 END, created_at_ms,"
    " deleted_at_ms, expires_at_ms";

Dive read_dive(soci::session& session, const std::string& id);  // throws Error{NotFound}

// Throws Error{Conflict} if the dive's state allows no jobs.
void require_usable(const Dive& dive);

// Returns the project's dive of this recording, unless it was refused; otherwise nullopt. Empty
// hashes match no dive.
std::optional<Dive> find_recording(soci::session& session,
                                   const std::string& project,
                                   const std::string& archive_sha256,
                                   const std::string& content_sha256);

// Appends an event of the dive, with the dive as its data.
void append_dive_event(soci::session& session, const Dive& dive, const std::string& type);

// Writes what people may edit of a dive, and what the recording says of it.
void write_description(soci::session& session, const Dive& dive);

// The decision of intake about a dive, with the reason of a refusal.
struct IntakeVerdict {
    Dive dive;
    std::optional<Failure> refusal;
};
// Writes the result of intake and decides: ready or refused. It also refuses a recording that
// differs from the one its client announced, or that the project has already.
IntakeVerdict apply_intake(soci::session& session,
                           const std::string& dive_id,
                           const IntakeResult& result);

}  // namespace divemesh::storage
